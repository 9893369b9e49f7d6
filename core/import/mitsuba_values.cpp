#include "core/import/mitsuba_values.h"

#include <charconv>
#include <cmath>

namespace qray {
namespace {

Vec3 to_vec3(const std::vector<double>& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

// "x", "y", "z" of a node, or "value" with three numbers or one for all; a missing one is `fill`.
Vec3 read_xyz(const MitsubaNode& node, float fill) {
  if (const std::string* value = node.attribute("value")) {
    const std::vector<double> numbers = parse_numbers(node, *value);
    if (numbers.size() == 1) return to_vec3({numbers[0], numbers[0], numbers[0]});
    if (numbers.size() != 3)
      node.fail("expected 1 or 3 numbers, got " + std::to_string(numbers.size()));
    return to_vec3(numbers);
  }
  Vec3 out{fill, fill, fill};
  const char* const axes[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i)
    if (const std::string* text = node.attribute(axes[i]))
      out[i] = static_cast<float>(parse_number(node, *text));
  return out;
}

Vec3 read_vector(const MitsubaNode& node, std::string_view key) {
  const std::vector<double> numbers = parse_numbers(node, node.need(key));
  if (numbers.size() != 3)
    node.fail("expected 3 numbers of \"" + std::string(key) + "\", got " +
              std::to_string(numbers.size()));
  return to_vec3(numbers);
}

Transform read_matrix(const MitsubaNode& node) {
  const std::vector<double> m = parse_numbers(node, node.need("value"));
  if (m.size() != 16 && m.size() != 9)
    node.fail("expected 16 numbers, or 9, got " + std::to_string(m.size()));
  const size_t columns = m.size() == 16 ? 4 : 3;
  Transform out;
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < columns; ++c) out.rows[r][c] = m[columns * r + c];
  if (columns == 4 && !(m[12] == 0 && m[13] == 0 && m[14] == 0 && m[15] == 1))
    node.fail("expected a last row of 0, 0, 0, 1");
  return out;
}

// Columns: left, up, the view, the origin.
Transform read_look_at(const MitsubaNode& node) {
  const Vec3 origin = read_vector(node, "origin"), target = read_vector(node, "target");
  const Vec3 forward = target - origin;
  if (!(length(forward) > 1e-6f)) node.fail("expected a target away from the origin");
  const Vec3 z = normalize(forward);
  Vec3 up = node.attribute("up") ? read_vector(node, "up") : Vec3{0, 0, 0};
  if (length(up) == 0) up = std::abs(z.y) < 0.9f ? Vec3{0, 1, 0} : Vec3{1, 0, 0};
  const Vec3 left = cross(up, z);
  if (!(length(left) > 1e-4f * length(up))) node.fail("expected an \"up\" other than the view");
  const Vec3 x = normalize(left), y = cross(z, x);
  Transform out;
  for (int r = 0; r < 3; ++r) out.rows[static_cast<size_t>(r)] = {x[r], y[r], z[r], origin[r]};
  return out;
}

Transform read_rotation(const MitsubaNode& node) {
  const Vec3 axis = read_xyz(node, 0);
  if (!(length(axis) > 0)) node.fail("expected an axis (x, y, z) of the rotation");
  return Transform::rotation(axis, static_cast<float>(parse_number(node, node.need("angle"))));
}

Transform read_step(const MitsubaNode& node) {
  if (node.tag == "translate") return Transform::translation(read_xyz(node, 0));
  if (node.tag == "scale") return Transform::scaling(read_xyz(node, 1));
  if (node.tag == "rotate") return read_rotation(node);
  if (node.tag == "matrix") return read_matrix(node);
  if (node.tag == "lookat" || node.tag == "lookAt" || node.tag == "look_at")
    return read_look_at(node);
  node.fail("expected translate, rotate, scale, lookat or matrix, got <" + node.tag + ">");
}

}  // namespace

std::vector<double> parse_numbers(const MitsubaNode& node, const std::string& text) {
  std::vector<double> out;
  const auto separates = [](char c) {
    return c == ',' || std::isspace(static_cast<unsigned char>(c)) != 0;
  };
  const char* at = text.data();
  const char* const end = at + text.size();
  for (;;) {
    while (at != end && separates(*at)) ++at;
    if (at == end) return out;
    const char* stop = at;
    while (stop != end && !separates(*stop)) ++stop;
    const std::string_view token(at, static_cast<size_t>(stop - at));
    if (*at == '+') ++at;
    double value = 0;
    const auto [parsed, error] = std::from_chars(at, stop, value);
    if (error != std::errc{} || parsed != stop || !std::isfinite(value))
      node.fail("expected a number, got \"" + std::string(token.substr(0, 40)) + "\"");
    out.push_back(value);
    at = stop;
  }
}

double parse_number(const MitsubaNode& node, const std::string& text) {
  const std::vector<double> numbers = parse_numbers(node, text);
  if (numbers.size() != 1) node.fail("expected a number, got \"" + text.substr(0, 40) + "\"");
  return numbers[0];
}

const MitsubaNode* find_parameter(const MitsubaNode& plugin, std::string_view name) {
  for (const MitsubaNode& child : plugin.children)
    if (child.name == name) return &child;
  return nullptr;
}

std::optional<double> find_number(const MitsubaNode& plugin, std::string_view name) {
  const MitsubaNode* node = find_parameter(plugin, name);
  if (!node) return {};
  return parse_number(*node, node->need("value"));
}

std::optional<bool> find_flag(const MitsubaNode& plugin, std::string_view name) {
  const MitsubaNode* node = find_parameter(plugin, name);
  if (!node) return {};
  const std::string& value = node->need("value");
  if (value != "true" && value != "false")
    node->fail("expected \"true\" or \"false\", got \"" + value + "\"");
  return value == "true";
}

std::optional<Vec3> find_point(const MitsubaNode& plugin, std::string_view name) {
  const MitsubaNode* node = find_parameter(plugin, name);
  if (!node) return {};
  return read_xyz(*node, 0);
}

const std::string* find_text(const MitsubaNode& plugin, std::string_view name) {
  const MitsubaNode* node = find_parameter(plugin, name);
  return node ? &node->need("value") : nullptr;
}

std::optional<Transform> find_transform(const MitsubaNode& plugin, std::string_view name) {
  const MitsubaNode* node = find_parameter(plugin, name);
  if (!node) return {};
  if (node->tag != "transform") node->fail("expected a <transform>, got <" + node->tag + ">");
  Transform out;
  for (const MitsubaNode& step : node->children) out = read_step(step).after(out);
  const double determinant = out.determinant();
  if (!(std::abs(determinant) > 1e-30) || !std::isfinite(determinant))
    node->fail("expected a transform that can be undone");
  return out;
}

}  // namespace qray
