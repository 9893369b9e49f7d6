// The table of job fields as a form needs it.
#include "proto/camera_json.h"
#include "proto/field_reader.h"

namespace qray::proto {
namespace {

using OrderedJson = nlohmann::ordered_json;

const char* type_name(FieldType type) {
  switch (type) {
    case FieldType::kSwitch:
      return "boolean";
    case FieldType::kWhole:
    case FieldType::kWhole64:
      return "integer";
    case FieldType::kNumber:
      return "number";
    case FieldType::kChoice:
      return "choice";
    case FieldType::kName:
      return "name";
    case FieldType::kText:
      return "text";
    case FieldType::kVector:
      return "vector";
    case FieldType::kLabels:
      return "labels";
    case FieldType::kCameras:
      return "cameras";
    case FieldType::kNames:
      return "names";
  }
  return "";
}

OrderedJson field_json(const Field& field, const RequestLimits& limits) {
  OrderedJson out = {{"path", field.path},
                     {"type", type_name(field.type)},
                     {"help", field.help},
                     {"label", field.label},
                     {"unit", field.unit}};
  if (field.type == FieldType::kWhole || field.type == FieldType::kNumber) {
    const auto number = [&](double v) {
      return field.type == FieldType::kWhole ? OrderedJson(static_cast<int64_t>(v))
                                             : OrderedJson(v);
    };
    out[field.above_least ? "exclusive_minimum" : "minimum"] = number(field.least);
    out["maximum"] = number(most_of(field, limits));
    if (!field.zero.empty()) out["word"] = field.zero;
  }
  if (field.type == FieldType::kChoice || field.type == FieldType::kNames) {
    out["choices"] = OrderedJson::array();
    for (const Choice& choice : field.choices)
      if (choice.callers & kJob)
        out["choices"].push_back({{"value", choice.value},
                                  {"label", choice.label.empty() ? choice.value : choice.label}});
    if (field.type == FieldType::kChoice) out["other"] = field.other;
  }
  if (field.fallback)
    std::visit([&](const auto& value) { out["default"] = value; }, *field.fallback);
  if (!field.methods.empty()) out["methods"] = field.methods;
  return out;
}

}  // namespace

std::string fields_to_json(const RequestLimits& limits, const FieldTable& fields) {
  OrderedJson list = OrderedJson::array();
  for (const Field& field : fields)
    if (field.callers & kJob) list.push_back(field_json(field, limits));
  return OrderedJson{{"fields", std::move(list)}}.dump();
}

}  // namespace qray::proto
