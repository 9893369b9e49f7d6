// What was asked for, by the fields' paths: values that were given, and no others. The server's and
// the clients' one type. Plain data; const calls from any thread.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

namespace qray {

using Labels = std::map<std::string, std::string>;
using Names = std::vector<std::string>;
using Vector3 = std::array<double, 3>;

// Members that are absent are taken from the scene's camera.
struct CameraRequest {
  std::optional<Vector3> position, target, up;
  std::optional<double> vertical_fov_deg, aperture_radius, focus_distance;
  std::optional<std::string> projection;  // one of kProjectionNames
  std::optional<double> height;
  bool operator==(const CameraRequest&) const = default;
};
// One of the scene's own, by its name ("*": each of them), or what is asked for.
struct CameraChoice {
  std::string name;  // empty: `camera`
  CameraRequest camera;
  bool operator==(const CameraChoice&) const = default;
};
using Cameras = std::vector<CameraChoice>;

using FieldValue =
    std::variant<bool, int64_t, uint64_t, double, std::string, Vector3, Labels, Cameras, Names>;

// A field that code acts on by name, with the type that its values have there. T is int or one of
// FieldValue's.
template <class T>
struct FieldName {
  std::string_view path;
};

namespace field {
inline constexpr FieldName<std::string> kScene{"scene"}, kMethod{"method"}, kTable{"table"},
    kPixels{"pixels"}, kRecover{"recover"};
inline constexpr FieldName<int> kWidth{"width"}, kHeight{"height"}, kSamples{"samples"},
    kMaxDepth{"max_depth"}, kPriority{"priority"}, kWorkers{"workers"};
inline constexpr FieldName<double> kSeconds{"seconds"}, kNoise{"noise"}, kFrameMs{"frame_ms"};
inline constexpr FieldName<uint64_t> kSeed{"seed"};
inline constexpr FieldName<bool> kNee{"nee"}, kLearning{"learning"}, kRecovery{"recovery"},
    kReprojection{"reprojection"}, kAlone{"alone"};
inline constexpr FieldName<Labels> kLabels{"labels"};
inline constexpr FieldName<Names> kPasses{"passes"};
inline constexpr FieldName<std::string> kLightGroups{"light_groups"}, kMix{"mix"};
// Of jobs of many frames.
inline constexpr FieldName<int> kTurntable{"frames/turntable"};
inline constexpr FieldName<Vector3> kCenter{"frames/center"}, kAxis{"frames/axis"};
inline constexpr FieldName<double> kDegrees{"frames/degrees"}, kAnimation{"frames/animation"},
    kFrom{"frames/from"}, kTo{"frames/to"};
inline constexpr FieldName<Cameras> kCameras{"frames/cameras"};
inline constexpr FieldName<std::string> kSeeds{"frames/seeds"};
}  // namespace field

class JobRequest {
 public:
  // Null where nothing was given. `path`: "samples", "guide/alpha", "camera/position".
  const FieldValue* find(std::string_view path) const {
    const auto found = values_.find(path);
    return found == values_.end() ? nullptr : &found->second;
  }
  void set(std::string_view path, FieldValue value) {
    values_.insert_or_assign(std::string(path), std::move(value));
  }
  void clear(std::string_view path) {
    if (const auto found = values_.find(path); found != values_.end()) values_.erase(found);
  }

  template <class T>
  std::optional<T> given(FieldName<T> name) const {
    const FieldValue* value = find(name.path);
    if (!value) return std::nullopt;
    return static_cast<T>(std::get<Stored<T>>(*value));
  }
  // What was given, else the default of the table of fields; T() where that has none.
  template <class T>
  T get(FieldName<T> name) const {
    if (const std::optional<T> value = given(name)) return *value;
    const FieldValue* fallback = default_of(name.path);
    return fallback ? static_cast<T>(std::get<Stored<T>>(*fallback)) : T();
  }
  template <class T>
  void set(FieldName<T> name, std::type_identity_t<T> value) {
    set(name.path, FieldValue(static_cast<Stored<T>>(std::move(value))));
  }
  template <class T>
  void clear(FieldName<T> name) {
    clear(name.path);
  }

  const std::map<std::string, FieldValue, std::less<>>& values() const { return values_; }
  bool operator==(const JobRequest&) const = default;

 private:
  template <class T>
  using Stored = std::conditional_t<std::is_same_v<T, int>, int64_t, T>;
  static const FieldValue* default_of(std::string_view path);

  std::map<std::string, FieldValue, std::less<>> values_;
};

}  // namespace qray
