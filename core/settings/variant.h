// A method with settings of its own, in one text: `method[:key=value[;key=value]...]`, such as
// "huang:grid=12;nee=off". What is not set is the renderer's default. The command's --method and
// charts take such texts; charts measure parts on and off by them. Any thread.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/settings/job_fields.h"

namespace qray {

// What the variant gives: its method, and its keys' fields. Keys are those of kVariant that
// `caller` has too. Errors name the method or the key, and what was expected; the ranges of values
// are check_settings' to judge.
Result<JobRequest> parse_variant(std::string_view variant, unsigned caller = kVariant,
                                 const FieldTable& fields = job_fields());
// "nee, depth, ...": for help.
std::string variant_keys(const FieldTable& fields = job_fields());

// `settings` with what the variant gives.
Result<RenderSettings> apply_variant(std::string_view variant, RenderSettings settings);

// "none,huang:grid=12" -> {"none", "huang:grid=12"}: each parsed and its values in range, none
// twice.
Result<std::vector<std::string>> parse_variants(std::string_view list);

struct MethodTraits {
  bool keeps_table = false, unbiased = true;
};
MethodTraits method_traits(std::string_view variant);  // of a variant that parses

}  // namespace qray
