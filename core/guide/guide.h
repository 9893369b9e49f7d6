// A guide turns what was learned about a scene's light into a density of directions. It knows
// points, normals, directions and radiance, so it is tested without a scene. Its parts stand in
// headers of their own, with their contracts and threads; who uses a guide takes the narrowest.
// This header has the whole, and the one list of methods.
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "core/base/result.h"
#include "core/guide/guide_inspector.h"
#include "core/guide/guide_learner.h"
#include "core/guide/guide_sampler.h"
#include "core/guide/guide_setup.h"
#include "core/guide/guide_table.h"

namespace qray {

class Guide : public GuideInspector, public GuideLearner, public GuideTable {};

// The method's name in a table's header: methods that learn the same values share tables.
std::string_view table_method(std::string_view method);

// The one list of methods. "none" gives a null guide. A guide takes at most `max_bytes` of memory
// (as its stats() count it): then it adds no states, and goes on learning about those it has.
std::span<const std::string_view> method_names();
Result<std::unique_ptr<Guide>> make_guide(std::string_view method, const GuideSetup& setup);

// What a guide of the method is made for that is to load these sections without their scene, as far
// as tables depend on it: bounds that give its grid, or its cube, again. kCorrupt; kUnsupported:
// the method has no tables.
Result<GuideSetup> setup_of_table(std::string_view method, std::span<const TableSection> sections);

}  // namespace qray
