#include "core/cmd/render_view.h"

#include <cstdio>

#include "core/cmd/files.h"
#include "core/image/image_io.h"
#include "core/job/run_job.h"
#include "core/render/debug_view.h"
#include "core/render/lobe_view.h"

namespace qray::cmd {
namespace {

constexpr int kViewSamples = 16;

Status write_view(const ViewOptions& o, const Image& image, const std::string& scale) {
  if (!o.quiet) std::fprintf(stderr, "qray: %s: %s\n", o.view.c_str(), scale.c_str());
  return write_image(o.out, image, {{"view", o.view}, {"scale", scale}});
}

Status render_lobe(const ViewOptions& o, const PreparedScene& scene, const RenderSettings& settings,
                   const Guide& guide) {
  Result<LobeView> view = render_lobe_view(scene, settings, guide, o.pixel[0], o.pixel[1]);
  if (!view) return view.error();
  if (!view.value().known)
    std::fprintf(stderr, "qray: the table knows nothing of the surface at this pixel\n");
  return write_view(o, view.value().image, std::string(kLobeScale));
}

}  // namespace

Status check_view(const ViewOptions& o) {
  if ((o.view == "lobe") != !o.pixel.empty())
    return Error{ErrorCode::kInvalid, "the view lobe is of a pixel X,Y, and no other is",
                 "--pixel"};
  const bool of_table = o.view == "lobe" || o.view == "beta" || o.view == "gain";
  if (of_table && o.table_in.empty())
    return Error{ErrorCode::kInvalid, "the view " + o.view + " shows a table: give one",
                 "--table-in"};
  if (!of_table && o.view != "state" && !o.table_in.empty())
    return Error{ErrorCode::kInvalid, "the view " + o.view + " has no table", "--table-in"};
  return {};
}

Status render_view(const ViewOptions& o, const PreparedScene& scene, RenderSettings settings,
                   TaskPool& pool, std::stop_token stop) {
  Result<std::optional<TableFile>> table = read_fitting_table(o.table_in, scene.hash);
  if (!table) return table.error();
  if (table.value() && !o.method_given) settings.method = table.value()->header.method;
  // Without a table, the states of the thesis' grid stand for a method that has none.
  if (!table.value() && settings.method == "none") settings.method = "huang";
  Result<std::unique_ptr<Guide>> guide = load_guide(scene, settings, table.value());
  if (!guide) return guide.error();
  const std::optional<DebugView> view = parse_debug_view(o.view);
  if (!view) return render_lobe(o, scene, settings, *guide.value());
  Result<Image> image =
      render_debug_view(scene, settings, *view, guide.value().get(), kViewSamples, pool, stop);
  if (!image) return image.error();
  return write_view(o, image.value(), std::string(scale_of(*view)));
}

}  // namespace qray::cmd
