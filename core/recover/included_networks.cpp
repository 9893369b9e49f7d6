#include "core/recover/included_networks.h"

#include "core/recover/pyramid.h"

// default.qrw, as it stands, in the program.
asm(".pushsection .rodata\n"
    ".balign 16\n"
    "qray_default_weights_begin:\n"
    ".incbin \"" QRAY_DEFAULT_WEIGHTS
    "\"\n"
    "qray_default_weights_end:\n"
    ".popsection\n");
extern "C" {
extern const uint8_t kDefaultWeightsBegin[] asm("qray_default_weights_begin");
extern const uint8_t kDefaultWeightsEnd[] asm("qray_default_weights_end");
}

namespace qray {

Result<Network> included_network(std::string_view name) {
  if (name == "bilinear") return Network{};
  if (name == "untrained") return untrained_network(1);
  if (name == "default") {
    const Result<WeightsFile> weights = decode_weights(
        {kDefaultWeightsBegin, static_cast<size_t>(kDefaultWeightsEnd - kDefaultWeightsBegin)});
    if (!weights.ok()) return weights.error();
    return weights.value().network;
  }
  return Error{ErrorCode::kInvalid, "there is no network '" + std::string(name) + "'", "/recover"};
}

}  // namespace qray
