// The names that a job may ask for, and scenes made of uploaded files. Any thread.
#pragma once

#include "server/api/scene_thumbnails.h"
#include "server/http/router.h"
#include "server/imports/scene_importer.h"
#include "server/store/job_store.h"
#include "server/store/scene_store.h"

namespace qray::server {

class SceneHandlers {
 public:
  struct Uses {
    SceneImporter& importer;
    SceneStore& scenes;
    UploadedScenes& uploads;
    AssetStore& assets;
    JobStore& jobs;
    SceneThumbnails& thumbnails;
    proto::RequestLimits limits;
  };
  explicit SceneHandlers(const Uses& uses) : uses_(uses) {}
  void add_to(Router& router);

 private:
  void create(const httplib::Request& req, httplib::Response& res);
  void get(httplib::Response& res, const std::string& name);
  void rename(const httplib::Request& req, httplib::Response& res, const std::string& name);
  void remove(httplib::Response& res, const std::string& name);
  void thumbnail(const httplib::Request& req, httplib::Response& res, const std::string& name);
  std::string json_of(const std::string& name);

  Uses uses_;
};

}  // namespace qray::server
