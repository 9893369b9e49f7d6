// `qray render --view`: pictures of a scene without its light, and of what a table knows. One
// thread.
#pragma once

#include <stop_token>
#include <string>
#include <vector>

#include "core/base/task_pool.h"
#include "core/render/prepared_scene.h"

namespace qray::cmd {

struct ViewOptions {
  std::string view;        // a DebugView's name, or "lobe"
  std::vector<int> pixel;  // x, y; of the lobe
  std::string table_in, out;
  bool method_given = false;  // else the table says it
  bool quiet = false;
};

Status check_view(const ViewOptions& options);
Status render_view(const ViewOptions& options, const PreparedScene& scene, RenderSettings settings,
                   TaskPool& pool, std::stop_token stop);

}  // namespace qray::cmd
