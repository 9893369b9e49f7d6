// A method as charts name it: `method[:key=value[;key=value]...]`, such as "huang:grid=12;nee=off".
// What is not set is the renderer's default. Variants are how a part is measured on and off. Any
// thread.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/render/settings.h"

namespace qray {

// `settings` with what the variant sets. Errors name the method or the key, and what was expected;
// the ranges of values are check_settings'.
Result<RenderSettings> apply_variant(std::string_view variant, RenderSettings settings);

// "none,huang:grid=12" -> {"none", "huang:grid=12"}: each parsed and its values in range, none
// twice.
Result<std::vector<std::string>> parse_variants(std::string_view list);

struct MethodTraits {
  bool keeps_table = false, unbiased = true;
};
MethodTraits method_traits(std::string_view variant);  // of a variant that parses

}  // namespace qray
