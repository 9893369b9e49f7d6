// Colours of Mitsuba scenes as linear Rec.709, as its RGB mode has them. Throws ImportFailure.
#pragma once

#include "core/import/mitsuba_import.h"

namespace qray {

// Of an index, what is negative is drawn as 0, with a warning; of others it is an error.
enum class ColorUse { kReflectance, kEmission, kIndex };

// Is it a colour rather than a texture? <rgb>, <srgb>, <spectrum>, <blackbody>, <float>.
bool is_color(const MitsubaNode& node);
// pre: is_color(node). Not negative; what its numbers mean beyond that is the caller's.
Rgb read_mitsuba_color(const MitsubaNode& node, ColorUse use, MitsubaImport& import);
// The plugin's colour parameter; `fallback` where it has none, or a texture, of which it warns.
Rgb find_color(const MitsubaNode& plugin, std::string_view name, Rgb fallback, ColorUse use,
               MitsubaImport& import);

}  // namespace qray
