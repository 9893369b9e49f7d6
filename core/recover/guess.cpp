#include "core/recover/guess.h"

#include "core/recover/upsample.h"

namespace qray {

Image Guess::of_all(const RecoveryInput& input, TaskPool& pool) {
  return all_.recover(network_.values, {input, exposure_of(input.colour)}, &pool);
}

Image Guess::of_quarter(const RecoveryInput& known, const Image& features, TaskPool& pool) {
  return upsampled(quarter_.recover(network_.values, {known, exposure_of(known.colour)}, &pool),
                   features, pool);
}

}  // namespace qray
