// qray diff: how far a picture is from its reference.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/cmd/commands.h"
#include "core/cmd/files.h"
#include "core/cmd/report.h"
#include "core/image/metrics.h"
#include "proto/json_text.h"

namespace qray::cmd {
namespace {

struct DiffOptions {
  std::string picture, reference;
  bool json = false;
};

Status run(const DiffOptions& o) {
  Result<Image> picture = read_linear_image(o.picture);
  if (!picture) return picture.error();
  Result<Image> reference = read_linear_image(o.reference);
  if (!reference) return reference.error();
  Result<ImageDifference> d = image_difference(picture.value(), reference.value());
  if (!d) return d.error();
  const proto::JsonField fields[] = {{"relmse", d.value().relmse},
                                     {"relmse_trimmed", d.value().relmse_trimmed},
                                     {"flip", d.value().flip},
                                     {"mean_ratio", d.value().mean_ratio},
                                     {"max_abs", d.value().max_abs}};
  if (o.json) {
    std::fputs(proto::json_object(fields).c_str(), stdout);
    return {};
  }
  for (const auto& [name, value] : fields)
    std::printf("%-15s %.6g\n", std::string(name).c_str(), std::get<double>(value));
  return {};
}

}  // namespace

void add_diff(CLI::App& app, int& exit_code) {
  auto o = std::make_shared<DiffOptions>();
  CLI::App* sub = app.add_subcommand("diff", "compare a picture with its reference");
  sub->add_option("picture", o->picture, "what is judged; 8-bit formats are read as sRGB")
      ->required();
  sub->add_option("reference", o->reference, "the truth")->required();
  sub->add_flag("--json", o->json,
                "relmse, relmse_trimmed (without the worst 0.1 % of pixels), flip, mean_ratio, "
                "max_abs as JSON");
  sub->callback([o, &exit_code] {
    if (Status s = run(*o); !s) exit_code = report(s.error());
  });
}

}  // namespace qray::cmd
