#include "core/cmd/render_options.h"

#include <CLI/CLI.hpp>
#include <charconv>

#include "core/render/variant.h"

namespace qray::cmd {

void add_render_options(CLI::App& app, RenderOptions& o) {
  app.add_option("scene", o.scene, "an included scene's name, a folder with scene.json, or a file")
      ->required();
  app.add_option("--method", o.method,
                 "none, huang-published (biased), huang, dahm-keller, ppg, adaptive (default); "
                 "rendered here also with settings, as qray chart --methods");
  app.add_flag("--no-nee", o.no_nee, "no direct light sampling");
  auto* samples = app.add_option("--spp", o.samples, "samples a pixel, learning counted");
  app.add_option("--seconds", o.seconds, "render as long as this instead")->excludes(samples);
  app.add_option(
      "--noise", o.noise,
      "stop when the picture's relative error, as its samples tell it, is that low; --spp "
      "or --seconds bound it (default: an hour)");
  app.add_option("--seed", o.seed, "of the random numbers; default 1");
  app.add_option("--size", o.size, "WIDTHxHEIGHT in pixels; default: the scene's");
  app.add_option("--pixels", o.pixels,
                 "which are sampled: all (default), quarter (one of each 2 x 2), adaptive (those, "
                 "more often where they are noisy)")
      ->check(CLI::IsMember({"all", "quarter", "adaptive"}));
  app.add_option("--recover", o.recover,
                 "make the picture whole by: none (default), auto (the scene's own network, else "
                 "the default one), default, untrained, bilinear; weights: docs/recover.md");
  app.add_option("--max-depth", o.max_depth, "surfaces on a path, at most");
  app.add_option("--learning-samples", o.learning_samples, "a pixel, at most a quarter of --spp");
  app.add_option("--alpha", o.alpha, "learning rate, 0..1");
  app.add_option("--gamma", o.gamma, "discount of what comes later, 0..1");
  app.add_option("--grid", o.grid, "cells along the scene's longest side, about");
}

Result<std::pair<int, int>> parse_size(const std::string& text) {
  int width = 0, height = 0;
  const char* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, width);
  if (first.ec == std::errc() && first.ptr != end && *first.ptr == 'x') {
    const auto second = std::from_chars(first.ptr + 1, end, height);
    if (second.ec == std::errc() && second.ptr == end && width > 0 && height > 0)
      return std::pair{width, height};
  }
  return Error{ErrorCode::kInvalid, "expected WIDTHxHEIGHT such as 640x480, got '" + text + "'",
               "--size"};
}

Result<RenderSettings> make_settings(const RenderOptions& o, const Scene& scene) {
  RenderSettings settings;
  settings.width = scene.width;
  settings.height = scene.height;
  settings.max_depth = scene.max_depth;
  if (!o.size.empty()) {
    const Result<std::pair<int, int>> size = parse_size(o.size);
    if (!size) return size.error();
    std::tie(settings.width, settings.height) = size.value();
  }
  settings.nee = !o.no_nee;
  if (o.method) {
    Result<RenderSettings> variant = apply_variant(*o.method, settings);
    if (!variant) return variant.error();
    settings = std::move(variant).value();
  }
  if (o.seconds) {
    settings.seconds = *o.seconds;
    settings.samples = 0;
  }
  if (o.noise) {
    constexpr double kNoiseSeconds = 3600;  // as the server has it
    settings.noise = *o.noise;
    if (!o.seconds) settings.seconds = kNoiseSeconds;
    settings.samples = 0;
  }
  if (o.samples) {
    settings.samples = *o.samples;
    settings.seconds = 0;
  }
  if (o.seed) settings.seed = *o.seed;
  if (o.pixels) settings.pixels = *pixels_named(*o.pixels);
  if (o.max_depth) settings.max_depth = *o.max_depth;
  if (o.learning_samples) settings.learning_samples = *o.learning_samples;
  if (o.alpha) settings.huang.alpha = *o.alpha;
  if (o.gamma) settings.huang.gamma = *o.gamma;
  if (o.grid) settings.huang.grid = *o.grid;
  return settings;
}

Result<proto::JobSubmission> make_submission(const RenderOptions& o) {
  proto::JobSubmission submission;
  submission.scene = o.scene;
  submission.method = o.method;
  if (o.no_nee) submission.nee = false;
  submission.samples = o.samples;
  submission.seconds = o.seconds;
  submission.noise = o.noise;
  submission.seed = o.seed;
  submission.max_depth = o.max_depth;
  submission.learning_samples = o.learning_samples;
  submission.alpha = o.alpha;
  submission.gamma = o.gamma;
  submission.grid = o.grid;
  submission.pixels = o.pixels;
  submission.recover = o.recover;
  if (!o.size.empty()) {
    const Result<std::pair<int, int>> size = parse_size(o.size);
    if (!size) return size.error();
    submission.width = size.value().first;
    submission.height = size.value().second;
  }
  return submission;
}

}  // namespace qray::cmd
