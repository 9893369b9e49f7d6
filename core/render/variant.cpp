#include "core/render/variant.h"

#include <algorithm>
#include <charconv>

namespace qray {
namespace {

template <class T>
bool set_number(std::string_view text, T& out) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  return error == std::errc() && end == text.data() + text.size();
}
bool set_switch(std::string_view text, bool& out) {
  out = text == "on";
  return out || text == "off";
}

struct Key {
  std::string_view name, expected;
  bool (*set)(std::string_view value, RenderSettings& s);
};
constexpr Key kKeys[] = {
    {"nee", "on or off", [](auto v, RenderSettings& s) { return set_switch(v, s.nee); }},
    {"roulette", "on or off",
     [](auto v, RenderSettings& s) { return set_switch(v, s.russian_roulette); }},
    {"light-table", "on or off",
     [](auto v, RenderSettings& s) { return set_switch(v, s.light_table); }},
    {"gate", "on or off", [](auto v, RenderSettings& s) { return set_switch(v, s.gate); }},
    {"pixels", "all, quarter or adaptive",
     [](auto v, RenderSettings& s) {
       const std::optional<Pixels> pixels = pixels_named(v);
       s.pixels = pixels.value_or(s.pixels);
       return pixels.has_value();
     }},
    {"recover", "none, bilinear, untrained or default",
     [](auto v, RenderSettings& s) {
       s.recover = v;
       return v == "none" || v == "bilinear" || v == "untrained" || v == "default";
     }},
    {"depth", "a whole number",
     [](auto v, RenderSettings& s) { return set_number(v, s.max_depth); }},
    {"learning", "samples a pixel",
     [](auto v, RenderSettings& s) { return set_number(v, s.learning_samples); }},
    {"grid", "a whole number",
     [](auto v, RenderSettings& s) { return set_number(v, s.huang.grid); }},
    {"alpha", "a number", [](auto v, RenderSettings& s) { return set_number(v, s.huang.alpha); }},
    {"gamma", "a number", [](auto v, RenderSettings& s) { return set_number(v, s.huang.gamma); }},
    {"split", "samples",
     [](auto v, RenderSettings& s) { return set_number(v, s.adaptive.split_samples); }},
    {"keep", "a number", [](auto v, RenderSettings& s) { return set_number(v, s.adaptive.keep); }},
    {"uniform", "a number",
     [](auto v, RenderSettings& s) { return set_number(v, s.adaptive.uniform); }},
    {"min-gain", "a number",
     [](auto v, RenderSettings& s) { return set_number(v, s.adaptive.min_gain); }},
    {"glossy", "a chance",
     [](auto v, RenderSettings& s) { return set_number(v, s.adaptive.glossy); }},
    {"shrinkage", "samples",
     [](auto v, RenderSettings& s) { return set_number(v, s.adaptive.direction.shrinkage); }},
    {"share", "a number",
     [](auto v, RenderSettings& s) { return set_number(v, s.adaptive.direction.split_share); }},
    {"split-gain", "a number",
     [](auto v, RenderSettings& s) { return set_number(v, s.adaptive.direction.min_split_gain); }},
    {"levels", "a whole number",
     [](auto v, RenderSettings& s) { return set_number(v, s.adaptive.direction.max_depth); }},
};

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

Status apply_pair(std::string_view variant, std::string_view pair, RenderSettings& settings) {
  std::string_view value = pair;
  const std::string_view name = next_part(value, '=');
  const auto key = std::find_if(std::begin(kKeys), std::end(kKeys),
                                [&](const Key& k) { return k.name == name; });
  if (key == std::end(kKeys))
    return invalid(variant, "unknown key '" + std::string(name) + "', expected one of " +
                                listed(kKeys, [](const Key& k) { return k.name; }));
  if (!key->set(value, settings))
    return invalid(variant, std::string(name) + ": expected " + std::string(key->expected) +
                                ", got '" + std::string(value) + "'");
  return {};
}

}  // namespace

Result<RenderSettings> apply_variant(std::string_view variant, RenderSettings settings) {
  std::string_view rest = variant;
  settings.method = next_part(rest, ':');
  const auto names = method_names();
  if (std::find(names.begin(), names.end(), settings.method) == names.end())
    return invalid(variant, "expected one of " + listed(names, [](auto n) { return n; }));
  if (variant.size() > settings.method.size() && rest.empty())
    return invalid(variant, "expected key=value after the colon");
  while (!rest.empty())
    if (Status s = apply_pair(variant, next_part(rest, ';'), settings); !s) return s.error();
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
  const bool sampled =
      settings.value().recover == "none" && settings.value().pixels != Pixels::kAdaptive;
  if (!guide.value()) return {false, sampled};
  return {true, sampled && guide.value()->unbiased()};
}

}  // namespace qray
