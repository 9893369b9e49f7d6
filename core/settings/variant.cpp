#include "core/settings/variant.h"

#include <algorithm>

#include "core/guide/guide.h"
#include "core/settings/job_settings.h"

namespace qray {
namespace {

// The part before the first `separator`; `rest` keeps what comes after it.
std::string_view next_part(std::string_view& rest, char separator) {
  const size_t end = std::min(rest.find(separator), rest.size());
  const std::string_view part = rest.substr(0, end);
  rest.remove_prefix(std::min(end + 1, rest.size()));
  return part;
}

template <class Names, class NameOf>
std::string listed(const Names& names, NameOf name_of) {
  std::string out;
  for (const auto& n : names) out += (out.empty() ? "" : ", ") + std::string(name_of(n));
  return out;
}

Error invalid(std::string_view variant, std::string message) {
  return {ErrorCode::kInvalid, std::move(message), "method '" + std::string(variant) + "'"};
}

std::string keys_of(const FieldTable& fields, unsigned caller) {
  std::string out;
  for (const Field& field : fields)
    if ((field.callers & kVariant) && (field.callers & caller) && field.path != "method")
      out += (out.empty() ? "" : ", ") + field.variant_key();
  return out;
}

Status read_pair(std::string_view variant, std::string_view pair, const FieldTable& fields,
                 unsigned caller, JobRequest& request) {
  std::string_view text = pair;
  const std::string name(next_part(text, '='));
  const auto field = std::find_if(fields.begin(), fields.end(), [&](const Field& f) {
    return (f.callers & kVariant) && (f.callers & caller) && f.path != "method" &&
           f.variant_key() == name;
  });
  if (field == fields.end())
    return invalid(variant,
                   "unknown key '" + name + "', expected one of " + keys_of(fields, caller));
  if (!field->of_method(request.get(field::kMethod)))
    return invalid(variant, name + ": " + not_of_method(*field, request.get(field::kMethod)));
  const Status set = set_from_text(*field, text, kVariant, request);
  return set.ok() ? set : invalid(variant, name + ": " + set.error().message);
}

}  // namespace

Result<JobRequest> parse_variant(std::string_view variant, unsigned caller,
                                 const FieldTable& fields) {
  JobRequest request;
  std::string_view rest = variant;
  const std::string method(next_part(rest, ':'));
  const auto names = method_names();
  if (std::find(names.begin(), names.end(), method) == names.end())
    return invalid(variant, "expected one of " + listed(names, [](auto n) { return n; }));
  if (variant.size() > method.size() && rest.empty())
    return invalid(variant, "expected key=value after the colon");
  request.set(field::kMethod, method);
  while (!rest.empty())
    if (Status s = read_pair(variant, next_part(rest, ';'), fields, caller, request); !s)
      return s.error();
  return request;
}

std::string variant_keys(const FieldTable& fields) { return keys_of(fields, kVariant); }

Result<RenderSettings> apply_variant(std::string_view variant, RenderSettings settings) {
  const Result<JobRequest> given = parse_variant(variant);
  if (!given) return given.error();
  apply(given.value(), settings);
  return settings;
}

Result<std::vector<std::string>> parse_variants(std::string_view list) {
  std::vector<std::string> variants;
  std::string_view rest = list;
  do {
    const std::string variant(next_part(rest, ','));
    const Result<RenderSettings> settings = apply_variant(variant, {});
    if (!settings) return settings.error();
    if (Status s = check_settings(settings.value(), int64_t{1} << 30); !s)
      return invalid(variant, s.error().text());
    if (std::find(variants.begin(), variants.end(), variant) != variants.end())
      return invalid(variant, "is named twice");
    variants.push_back(variant);
  } while (!rest.empty());
  return variants;
}

MethodTraits method_traits(std::string_view variant) {
  const Result<RenderSettings> settings = apply_variant(variant, {});
  QRAY_CHECK(settings.ok());
  const Result<std::unique_ptr<Guide>> guide = make_guide(settings.value().method, GuideSetup{});
  QRAY_CHECK(guide.ok());
  const bool sampled = settings.value().recover == "none";
  if (!guide.value()) return {false, sampled};
  return {true, sampled && guide.value()->unbiased()};
}

}  // namespace qray
