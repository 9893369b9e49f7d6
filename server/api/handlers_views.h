// GET /v1/jobs/{id}/pixel, view.png and lobe.png: what is known at a pixel, and what a job's table
// knows, as pictures; of an ended job, of a moment that was kept, or of the newest moment while it
// runs. Unlike the other handlers these work: they load the table and trace first hits, on one
// thread, one answer at a time, and hold no lock meanwhile. Any thread.
#pragma once

#include <semaphore>
#include <stop_token>

#include "core/image/image_io.h"
#include "core/render/debug_view.h"
#include "server/api/picture_source.h"
#include "server/http/router.h"

namespace qray::server {

class ViewHandlers {
 public:
  ViewHandlers(const PictureSource& pictures, Stores stores)
      : pictures_(pictures), stores_(stores) {}
  void add_to(Router& router);
  void stop() { stop_.request_stop(); }  // pictures that are being made are given up

 private:
  using Request = httplib::Request;
  using Response = httplib::Response;
  struct Shown;
  struct Wanted;  // a job, and which of its tables

  void pixel(const Request& req, Response& res, const std::string& id);
  void view(const Request& req, Response& res, const std::string& id);
  void guide_view(const Request& req, Response& res, const std::string& id, DebugView view);
  void noise_view(const Request& req, Response& res, const std::string& id, bool samples);
  void lobe(const Request& req, Response& res, const std::string& id);
  Result<Wanted> wanted(const Request& req, const std::string& id) const;
  // kConflict: scene or table cannot be had; `needs_guide`: nor is there one.
  Result<std::shared_ptr<const Shown>> load(const Wanted& wanted, bool needs_guide);
  struct FoundTable {
    std::string key;      // of what it holds, for this job; empty: there is none
    uint32_t moment = 0;  // whose it is; 0: the one that the job left
  };
  Result<FoundTable> find_table(const Wanted& wanted) const;
  Result<std::optional<TableFile>> read_table(const JobRecord& job, const FoundTable& found);

  const PictureSource& pictures_;
  Stores stores_;
  std::stop_source stop_;
  std::counting_semaphore<> turns_{1};  // a table may take a quarter of a GiB
  // The last one, while it is small: a pointer moves over pixel after pixel. Who has the turn.
  std::shared_ptr<const Shown> last_;
};

}  // namespace qray::server
