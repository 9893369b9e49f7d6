#include "core/import/gltf_motion.h"

#include <algorithm>
#include <cmath>

namespace qray {
namespace {

constexpr size_t kMaxKeys = 1'000'000;       // of an accessor, and slopes
constexpr size_t kMaxNumbers = 100'000'000;  // of all

class MotionReader {
 public:
  explicit MotionReader(GltfImport& import) : import_(import), model_(import.document.model()) {}

  GltfMotions read() {
    for (size_t i = 0; i < model_.animations.size(); ++i) {
      const JsonNode place = import_.document.at("animations", static_cast<int>(i));
      for (const GltfModel::Channel& channel : model_.animations[i]) add(channel, place);
    }
    return {motions_.begin(), motions_.end()};
  }

 private:
  void add(const GltfModel::Channel& channel, const JsonNode& place) {
    std::shared_ptr<NodeMotion>& found_motion = motions_[channel.node];
    if (!found_motion) found_motion = std::make_shared<NodeMotion>();
    NodeMotion& motion = *found_motion;
    const struct {
      const char* path;
      Track& track;
      int components;
    } known[] = {{"translation", motion.translation, 3},
                 {"rotation", motion.rotation, 4},
                 {"scale", motion.scale, 3},
                 {"weights", motion.weights, 1}};
    const auto* const found =
        std::ranges::find_if(known, [&](const auto& one) { return channel.path == one.path; });
    if (found == std::end(known))
      return import_.warn(place, "what moves \"" + channel.path + "\" is left out");
    if (!found->track.seconds.empty())
      return import_.warn(place, "another animation moves the same node: this one is left out");
    found->track = track_of(channel, found->components);
    found->track.turns = channel.path == "rotation";
  }

  Track track_of(const GltfModel::Channel& channel, int components) {
    Track track;
    track.between = channel.between;
    const GltfAccessor times(import_, channel.input, 1, kMaxKeys);
    const GltfAccessor values(import_, channel.output, components, kMaxKeys);
    numbers_ += times.count() + values.count() * static_cast<size_t>(components);
    if (numbers_ > kMaxNumbers)
      times.node().fail(
          "expected at most " + std::to_string(kMaxNumbers) + " numbers of all that moves",
          ErrorCode::kTooLarge);
    track.seconds = times.read<float>();
    for (size_t i = 0; i < track.seconds.size(); ++i)
      if (!(track.seconds[i] >= 0 && std::isfinite(track.seconds[i])) ||
          (i > 0 && !(track.seconds[i] > track.seconds[i - 1])))
        times.node().fail("expected rising seconds from 0");
    const size_t parts =
        times.count() * (track.between == Track::Between::kCubic ? size_t{3} : size_t{1});
    // Of weights a value has as many as the mesh has targets.
    const size_t elements = components == 1 ? values.count() / parts : 1;
    if (elements == 0 || values.count() != parts * elements)
      values.node().get("count").fail_expected((components == 1 ? "a multiple of " : "") +
                                               std::to_string(parts) + ", for so many keys");
    track.width = elements * static_cast<size_t>(components);
    track.values.resize(parts * track.width);
    read_into(values, components, track.values);
    for (const float v : track.values)
      if (!(std::abs(v) <= 1e9f)) values.node().fail("expected numbers within 1e9");
    return track;
  }

  static void read_into(const GltfAccessor& from, int components, std::vector<float>& out) {
    const auto copy = [&](const auto& elements) {
      std::memcpy(out.data(), elements.data(), out.size() * sizeof(float));
    };
    if (components == 1)
      copy(from.read<float>());
    else if (components == 3)
      copy(from.read<std::array<float, 3>>());
    else
      copy(from.read<std::array<float, 4>>());
  }

  GltfImport& import_;
  const GltfModel& model_;
  std::map<int, std::shared_ptr<NodeMotion>> motions_;
  size_t numbers_ = 0;
};

}  // namespace

GltfMotions read_gltf_motions(GltfImport& import) { return MotionReader(import).read(); }

}  // namespace qray
