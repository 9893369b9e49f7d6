// Mitsuba's sensor, film and integrator: the view, the picture's size and the paths' length.
// Throws ImportFailure.
#pragma once

#include "core/import/mitsuba_import.h"

namespace qray {

void read_sensor(const MitsubaNode& sensor, MitsubaImport& import);
void read_integrator(const MitsubaNode& integrator, MitsubaImport& import);

}  // namespace qray
