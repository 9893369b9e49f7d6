// A guide turns what was learned about a scene's light into a density of directions. It may be
// wrong, never biasing: its exact pdf is always divided out (`huang-published` alone pretends one,
// and says so by unbiased()). A guide knows points, normals, directions and radiance, so it is
// tested without a scene.
// Threads: const calls from any thread, also while update runs; update and end_pass from one thread
// at a time, end_pass while no other call runs.
// Frames: everything in world space. Densities are per steradian.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/base/snapshot.h"
#include "core/guide/adaptive_params.h"
#include "core/guide/huang_params.h"
#include "core/guide/table_file.h"
#include "core/math/frame.h"
#include "core/math/ray.h"

namespace qray {

constexpr size_t kDefaultTableBytes = size_t{256} << 20;  // of memory, unless a job says otherwise

// One lookup, shared by sample, pdf_w and record.
struct GuidePoint {
  StateId state;           // invalid: nothing is known here yet
  uint64_t key = 0;        // the state's name in the table, known or not
  Frame frame{{0, 0, 1}};  // z: the hemisphere that is sampled lies about it
};

struct GuideSample {
  Vec3 wi;          // unit, away from the surface
  float pdf_w = 0;  // what pdf_w(point, wi) gives
};

// A part of the directions that a guide tells apart at a point: a standard direction of the thesis,
// or a cell of the unit square that a method lays over its directions.
struct DirectionCell {
  Vec3 wi;  // its middle
  float pdf_w = 0;
  Vec2 corner;     // the cell's nearest to (0, 0)
  float size = 0;  // of the cell's sides; 0: not a cell of a square
};

// What is known of a state, for a person who looks at it.
struct StateSummary {
  float size_m = 0;                // its longest side; 0: has none
  std::optional<uint64_t> visits;  // that its directions were learned from
};

// What a table expects where it knows enough. Nothing rests on it being right.
struct GuideExpectation {
  bool credible = false;
  // Mean over the projected hemisphere of the radiance that arrives, the light's share that nee
  // counts left out: a diffuse surface sends reflectance x arriving.
  Rgb arriving;
  float deviation = 0;  // standard, of the luminance of one sample of `arriving`
};

// One scattering event of a path, as a guide learns from it.
struct GuideVertex {
  GuidePoint at;
  Vec3 p;                 // metres
  Vec3 wi;                // the direction taken
  float bsdf_pdf_w = 0;   // the BSDF's density for it
  float f_cos = 0;        // luminance of f |cos|
  float pdf_w = 0;        // the density it was drawn with
  float albedo = 0;       // luminance of the surface's, seen from where the path came
  bool guidable = false;  // not a delta lobe
  bool lands = false;     // the next vertex of the path is where the ray landed
  // What the direction was paid: radiance, nee's share left out, the further path as the guide
  // expects it where it can, else as it went.
  Rgb arriving;
  // Luminance emitted toward here by what the ray reached, no MIS weight; or scattered toward here
  // of lights that no ray reaches.
  float emitted = 0;
};

// What one tile of one pass learned; each guide has its own kind.
class GuideDelta {
 public:
  virtual ~GuideDelta() = default;
};

struct GuideStats {
  size_t states = 0;
  size_t direction_nodes = 0;  // of trees, where the method has them
  size_t bytes = 0;            // of memory
  uint64_t samples_seen = 0;   // transitions learned from, in all jobs
  uint64_t refused = 0;        // transitions that found no room for their state: the table is full
};

class Guide {
 public:
  virtual ~Guide() = default;
  virtual std::string_view method() const = 0;
  virtual bool unbiased() const = 0;

  // n: unit geometric normal on the side that the light is reflected to.
  virtual GuidePoint find(Vec3 p, Vec3 n) const = 0;
  // The chance to draw from the guide rather than the BSDF, on a diffuse or another surface.
  virtual float guide_fraction(const GuidePoint& point, bool diffuse) const = 0;
  virtual GuideSample sample(const GuidePoint& point, Vec2 u) const = 0;
  virtual float pdf_w(const GuidePoint& point, Vec3 wi) const = 0;  // integrates to 1

  // By how much less the learned density makes a sample's second moment than the density that the
  // method starts from (over the projected hemisphere, the hemisphere or the sphere), if light
  // arrives as the table says. 1 where nothing is known. For views; slower than a lookup.
  virtual float gain(const GuidePoint&) const { return 1; }

  // For views, as gain(): of a point that is known here, while nothing is learned.
  virtual std::vector<DirectionCell> directions(const GuidePoint&) const { return {}; }
  virtual StateSummary summary(const GuidePoint&) const { return {}; }

  // Whether the method has expectations at all, and what it expects.
  virtual bool expects() const { return false; }
  virtual GuideExpectation expectation(const GuidePoint&) const { return {}; }

  virtual std::unique_ptr<GuideDelta> make_delta() const = 0;
  virtual void record(std::span<const GuideVertex> path, GuideDelta& delta) const = 0;
  // Deltas arrive in the order of their tiles, whatever thread made them. `delta` came from
  // make_delta(), and is empty again afterwards.
  virtual void update(GuideDelta& delta) = 0;
  virtual void end_pass() = 0;  // what was updated rules sampling from here on
  // The picture gains little by a larger table: from here on, where the method can, it learns
  // about the states that it has.
  virtual void stop_growing() {}

  virtual GuideStats stats() const = 0;
  virtual std::vector<TableSection> save() const = 0;
  // Into a fresh guide. kTooLarge: over the guide's memory.
  virtual Status load(std::span<const TableSection> sections) = 0;

  // All of it, within a pass too: one that reads what another wrote goes on to the same bits. Only
  // between tiles. `in` tells what does not fit by its ok(); this one is then of no more use.
  virtual void save_state(SnapshotWriter& out) const = 0;
  virtual void load_state(SnapshotReader& in) = 0;

  // Adds what `other` learned in the same scene, between passes; it rules sampling at once. Which
  // of two is added to which changes no bit of what is saved. kInvalid: another method's, or what
  // this one's tables hold cannot be added; kConflict: another grid; kTooLarge: no room. An error
  // leaves the guide as it was.
  virtual Status merge(const Guide& other);
  // The scene has changed since the table was learned: where the method counts, what it knows
  // counts a sixteenth.
  virtual void doubt() {}
  // Up to `most` of the states that sampling knows, spread over the table: for checks and views.
  virtual std::vector<GuidePoint> known_points(size_t /*most*/) const { return {}; }
};

// What a guide is made for.
struct GuideSetup {
  Bounds3 bounds;             // of the scene, metres
  float brightest_light = 1;  // luminance
  size_t max_bytes = kDefaultTableBytes;
  HuangParams huang;
  AdaptiveParams adaptive;
};

// At most `most` of the points, evenly from first to last.
std::vector<GuidePoint> spread_over(std::vector<GuidePoint> points, size_t most);

// The method's name in a table's header: methods that learn the same values share tables.
std::string_view table_method(std::string_view method);

// The one list of methods. "none" gives a null guide. A guide takes at most `max_bytes` of memory
// (as its stats() count it): then it adds no states, and goes on learning about those it has.
std::span<const std::string_view> method_names();
Result<std::unique_ptr<Guide>> make_guide(std::string_view method, const GuideSetup& setup);

}  // namespace qray
