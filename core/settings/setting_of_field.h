// How rows of the table of fields name their members of RenderSettings. Pure.
#pragma once

#include <type_traits>

#include "core/settings/field.h"

namespace qray {

constexpr unsigned kEverywhere = kJob | kLive | kRender | kSubmit | kVariant;

// A member of RenderSettings as a setting: `member` gives a reference to it.
template <class Member>
SettingOfField setting(Member member) {
  using T = std::remove_cvref_t<decltype(member(std::declval<RenderSettings&>()))>;
  return {[member](RenderSettings& s, const FieldValue& value) {
            std::visit(
                [&](const auto& v) {
                  if constexpr (std::is_arithmetic_v<T> &&
                                std::is_arithmetic_v<std::remove_cvref_t<decltype(v)>>)
                    member(s) = static_cast<T>(v);
                  else if constexpr (std::is_same_v<T, std::remove_cvref_t<decltype(v)>>)
                    member(s) = v;
                },
                value);
          },
          [member](const RenderSettings& s) -> std::optional<FieldValue> {
            const T& value = member(const_cast<RenderSettings&>(s));
            if constexpr (std::is_same_v<T, float>)
              return FieldValue(short_double(value));
            else if constexpr (std::is_same_v<T, int>)
              return FieldValue(int64_t{value});
            else
              return FieldValue(value);
          }};
}

// The same, but what does not pass `asked` counts as not asked for.
template <class Member, class Asked>
SettingOfField setting_if(Member member, Asked asked) {
  SettingOfField out = setting(member);
  out.read = [asked, read = out.read](const RenderSettings& s) {
    return asked(s) ? read(s) : std::nullopt;
  };
  return out;
}

// With the value that new settings have.
inline Field with_default(Field field) {
  field.fallback = field.setting.read(RenderSettings());
  return field;
}

}  // namespace qray
