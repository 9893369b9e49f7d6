// Mitsuba's emitters that are not surfaces. Throws ImportFailure.
#pragma once

#include "core/import/mitsuba_import.h"

namespace qray {

void read_emitter(const MitsubaNode& emitter, MitsubaImport& import);

}  // namespace qray
