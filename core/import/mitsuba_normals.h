// Vertex normals for meshes that bring none, as Mitsuba makes them. Pure functions.
#pragma once

#include "core/scene/scene.h"

namespace qray {

// Of the faces at a vertex, weighed by their angle there (Thuermer and Wuethrich 1998).
void smooth_normals(Mesh& mesh);
// Faces whose normals differ by more than `max_angle_deg` share no normal, whatever vertices they
// share; others do where their vertices have one position.
void smooth_normals(Mesh& mesh, float max_angle_deg);

}  // namespace qray
