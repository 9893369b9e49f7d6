#include "core/bsdf/diffuse.h"

#include "core/bsdf/kinds.h"

namespace qray {

std::unique_ptr<Bsdf> make_diffuse() { return std::make_unique<Diffuse>(); }

}  // namespace qray
