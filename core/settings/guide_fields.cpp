#include "core/settings/guide_fields.h"

#include "core/guide/guide.h"
#include "core/guide/surface_grid.h"
#include "core/settings/setting_of_field.h"

namespace qray {
namespace {

// For who chooses a method on the page.
constexpr std::pair<std::string_view, const char*> kMethodLabels[] = {
    {"none", "none: no learning"},
    {"huang-published", "huang as published: learns, biased"},
    {"huang", "huang: learns, unbiased"},
    {"dahm-keller", "Dahm-Keller: learns radiance in 64 directions, unbiased"},
    {"ppg", "PPG (practical path guiding): learns, unbiased"},
    {"adaptive", "adaptive: learns where light comes from, unbiased"}};

template <class Member>
Field guide_setting(std::string name, std::vector<std::string> methods, std::string help,
                    std::string label, std::pair<double, double> range, Member member) {
  using T = std::remove_cvref_t<decltype(member(std::declval<RenderSettings&>()))>;
  return with_default({.path = "guide/" + std::move(name),
                       .type = std::is_same_v<T, int> ? FieldType::kWhole : FieldType::kNumber,
                       .help = std::move(help),
                       .label = std::move(label),
                       .least = range.first,
                       .most = range.second,
                       .callers = kJob | kSubmit | kRender | kVariant,
                       .methods = std::move(methods),
                       .setting = setting(member)});
}

}  // namespace

Field method_field() {
  Field field{.path = "method",
              .type = FieldType::kChoice,
              .help =
                  "How a path's directions are chosen: none traces paths plainly, the others learn "
                  "where light comes from.",
              .label = "Method",
              .callers = kEverywhere,
              .setting = setting([](RenderSettings & s) -> auto& { return s.method; })};
  for (std::string_view name : method_names()) {
    Choice choice{std::string(name)};
    for (const auto& [method, label] : kMethodLabels)
      if (method == name) choice.label = label;
    field.choices.push_back(std::move(choice));
  }
  return with_default(std::move(field));
}

FieldTable guide_fields() {
  FieldTable out;
  const std::vector<std::string> huang{"huang", "huang-published"}, adaptive{"adaptive"};
  out.push_back(guide_setting(
      "alpha", huang, "The learning rate.", "Alpha", {0, 1},
      [](RenderSettings & s) -> auto& { return s.huang.alpha; }));
  out.push_back(guide_setting(
      "gamma", huang, "The discount of what a path earns later.", "Gamma", {0, 1},
      [](RenderSettings & s) -> auto& { return s.huang.gamma; }));
  out.push_back(guide_setting(
      "grid", {"huang", "huang-published", "dahm-keller"},
      "About how many cells lie along the scene's longest side.", "Grid",
      {1, SurfaceGrid::kMaxGrid}, [](RenderSettings & s) -> auto& { return s.huang.grid; }));
  out.push_back(guide_setting(
      "split", adaptive, "A place that was hit by more samples in a pass is cut in two.",
      "Samples that cut a place", {1, 1e9},
      [](RenderSettings & s) -> auto& { return s.adaptive.split_samples; }));
  out.push_back(guide_setting(
      "keep", adaptive, "The least part of what is known at a place that a pass keeps.",
      "Kept each pass", {0, 1}, [](RenderSettings & s) -> auto& { return s.adaptive.keep; }));
  out.push_back(guide_setting(
      "uniform", adaptive, "About the part of each place's density that is uniform.",
      "Uniform part", {0, 1}, [](RenderSettings & s) -> auto& { return s.adaptive.uniform; }));
  out.push_back(guide_setting(
      "min_gain", adaptive,
      "A place whose directions gain less than this draws from the BSDF alone.", "Least gain",
      {0, 1e6}, [](RenderSettings & s) -> auto& { return s.adaptive.min_gain; }));
  out.push_back(with_default(
      {.path = "guide/lights",
       .type = FieldType::kSwitch,
       .help = "Which lights send how much to which places is learned, and picks lights.",
       .label = "Learn which lights matter where",
       .callers = kJob | kSubmit | kRender | kVariant,
       .methods = adaptive,
       .setting = setting([](RenderSettings & s) -> auto& { return s.adaptive.lights; })}));
  out.push_back(with_default(
      {.path = "guide/caustics",
       .type = FieldType::kSwitch,
       .help = "Paths aim at where mirrors and glass send light from, as photons show.",
       .label = "Aim at caustics",
       .callers = kJob | kSubmit | kRender | kVariant,
       .methods = adaptive,
       .setting = setting([](RenderSettings & s) -> auto& { return s.adaptive.caustics; })}));
  out.push_back(with_default(
      {.path = "guide/by_noise",
       .type = FieldType::kSwitch,
       .help = "Pixels get more samples where the picture is noisy.",
       .label = "More samples where it is noisy",
       .callers = kJob | kSubmit | kRender | kVariant,
       .methods = adaptive,
       .setting = setting([](RenderSettings & s) -> auto& { return s.adaptive.by_noise; })}));
  out.push_back(guide_setting(
      "glossy", adaptive,
      "The chance that the guide is drawn from in place of a rough lobe; -1: learned for each "
      "place.",
      "Guided in place of rough lobes", {-1, 1},
      [](RenderSettings & s) -> auto& { return s.adaptive.glossy; }));
  out.push_back(guide_setting(
      "shrinkage", adaptive,
      "How far a cell of directions is drawn toward the estimate of the cell around it, in "
      "samples.",
      "Shrinkage", {0, 1e6},
      [](RenderSettings & s) -> auto& { return s.adaptive.direction.shrinkage; }));
  out.push_back(guide_setting(
      "share", adaptive,
      "A cell of directions with a larger part of what arrives at its place is cut in four.",
      "Share that cuts a cell", {0, 1},
      [](RenderSettings & s) -> auto& { return s.adaptive.direction.split_share; }));
  out.push_back(guide_setting(
      "split_gain", adaptive,
      "By how much such a cut must raise the density's second moment, as a part of it.",
      "Least gain of a cut", {-1, 1},
      [](RenderSettings & s) -> auto& { return s.adaptive.direction.min_split_gain; }));
  out.push_back(guide_setting(
      "levels", adaptive, "How often a cell of directions may be cut.", "Levels", {0, 12},
      [](RenderSettings & s) -> auto& { return s.adaptive.direction.max_depth; }));
  return out;
}

}  // namespace qray
