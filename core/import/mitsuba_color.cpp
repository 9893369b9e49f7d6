#include "core/import/mitsuba_color.h"

#include <algorithm>
#include <charconv>
#include <sstream>

#include "core/base/file.h"
#include "core/image/tonemap.h"
#include "core/import/spectrum.h"
#include "core/scene/value_ranges.h"

namespace qray {
namespace {

constexpr uint64_t kMaxSpectrumBytes = 1 << 20;
constexpr size_t kMaxPoints = 65'536;

void add_point(const MitsubaNode& node, std::vector<SpectrumPoint>& points, SpectrumPoint p) {
  if (!points.empty() && !(p.nm > points.back().nm))
    node.fail("expected wavelengths that rise, got " + std::to_string(p.nm));
  if (points.size() >= kMaxPoints)
    node.fail("expected at most 65536 wavelengths", ErrorCode::kTooLarge);
  points.push_back(p);
}

// "400:0.1, 500:0.2"
std::vector<SpectrumPoint> parse_pairs(const MitsubaNode& node, std::string text) {
  const auto pairs = static_cast<size_t>(std::count(text.begin(), text.end(), ':'));
  std::replace(text.begin(), text.end(), ':', ' ');
  const std::vector<double> numbers = parse_numbers(node, text);
  if (numbers.size() != 2 * pairs) node.fail("expected pairs of wavelength:value");
  std::vector<SpectrumPoint> points;
  for (size_t i = 0; i < numbers.size(); i += 2)
    add_point(node, points, {numbers[i], numbers[i + 1]});
  return points;
}

// Lines of "wavelength value"; # starts a comment.
std::vector<SpectrumPoint> read_spd(const MitsubaNode& node, const std::string& name,
                                    const MitsubaDocument& document) {
  const Result<Bytes> bytes = read_file(document.find_file(node, name), kMaxSpectrumBytes);
  if (!bytes.ok()) node.fail("\"" + name + "\": " + bytes.error().message, bytes.error().code);
  std::istringstream lines(std::string(bytes.value().begin(), bytes.value().end()));
  std::vector<SpectrumPoint> points;
  for (std::string line; std::getline(lines, line);) {
    const std::vector<double> numbers = parse_numbers(node, line.substr(0, line.find('#')));
    if (numbers.empty()) continue;
    if (numbers.size() != 2) node.fail("\"" + name + "\": expected lines of wavelength and value");
    add_point(node, points, {numbers[0], numbers[1]});
  }
  if (points.empty()) node.fail("\"" + name + "\" is empty, expected wavelengths and values");
  return points;
}

double read_kelvin(const MitsubaNode& node, std::string text) {
  if (!text.empty() && (text.back() == 'K' || text.back() == 'k')) text.pop_back();
  const double kelvin = parse_number(node, text);
  if (!(kelvin > 0 && kelvin <= 1e6)) node.fail("expected a temperature over 0 and up to 1e6 K");
  return kelvin;
}

class ColorReader {
 public:
  ColorReader(const MitsubaNode& node, ColorUse use, MitsubaImport& import)
      : node_(node), use_(use), import_(import) {}

  Rgb read() const {
    if (node_.tag == "srgb") return srgb_to_linear(read_triple(node_.need("value")));
    if (node_.tag == "blackbody") {
      const std::string* scale = node_.attribute("scale");
      return blackbody(read_kelvin(node_, node_.need("temperature")),
                       scale ? parse_number(node_, *scale) : 1);
    }
    if (node_.tag != "spectrum") return read_triple(node_.need("value"));
    if (!node_.type.empty()) return read_plugin();
    if (const std::string* file = node_.attribute("filename"))
      return integrate(read_spd(node_, *file, import_.document));
    const std::string& value = node_.need("value");
    return value.find(':') == std::string::npos ? read_triple(value)
                                                : integrate(parse_pairs(node_, value));
  }

 private:
  Rgb to_rgb(const std::vector<double>& v) const {
    if (v.size() != 1 && v.size() != 3)
      node_.fail("expected 1 or 3 numbers, got " + std::to_string(v.size()));
    Rgb out;
    for (int i = 0; i < 3; ++i) {
      const double number = v[v.size() == 3 ? static_cast<size_t>(i) : 0];
      if (number < 0 && use_ != ColorUse::kIndex)
        node_.fail("expected numbers from 0, got " + std::to_string(number));
      out[i] = static_cast<float>(number);
    }
    return out;
  }

  // "0.2 0.4 0.8", "0.5" or "#3366cc".
  Rgb read_triple(const std::string& text) const {
    const size_t first = text.find_first_not_of(' ');
    if (first == std::string::npos || text[first] != '#') return to_rgb(parse_numbers(node_, text));
    unsigned bits = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data() + first + 1, end, bits, 16);
    if (error != std::errc{} || stop != end || text.size() - first != 7)
      node_.fail("expected six digits as in #3366cc, got \"" + text.substr(first, 20) + "\"");
    const auto channel = [bits](int shift) {
      return static_cast<float>(bits >> shift & 255) / 255;
    };
    return {channel(16), channel(8), channel(0)};
  }

  Rgb integrate(const std::vector<SpectrumPoint>& points) const {
    const bool d65 = use_ == ColorUse::kReflectance && import_.document.version >= 2;
    return spectrum_to_rgb(points, d65 ? SpectrumWeight::kD65 : SpectrumWeight::kEqualEnergy);
  }
  Rgb blackbody(double kelvin, double scale) const {
    if (scale < 0) node_.fail("expected a scale from 0");
    return blackbody_to_rgb(kelvin) * static_cast<float>(scale);
  }

  // Mitsuba 3's <spectrum type="...">.
  Rgb read_plugin() const {
    if (node_.type == "blackbody") {
      const MitsubaNode* temperature = find_parameter(node_, "temperature");
      if (!temperature) node_.fail("expected a \"temperature\"");
      return blackbody(read_kelvin(*temperature, temperature->need("value")),
                       find_number(node_, "scale").value_or(1));
    }
    if (node_.type == "uniform" || node_.type == "d65") {
      const double v = find_number(node_, node_.type == "d65" ? "scale" : "value").value_or(1);
      return to_rgb({v});
    }
    if (node_.type == "irregular" || node_.type == "regular") return integrate(listed());
    import_.warn(node_, "spectra of type \"" + node_.type + "\" are drawn as 0.5");
    return Rgb{0.5f};
  }
  std::vector<SpectrumPoint> listed() const {
    const std::string* values = find_text(node_, "values");
    if (!values) node_.fail("expected \"values\"");
    const std::vector<double> numbers = parse_numbers(node_, *values);
    std::vector<double> wavelengths;
    if (const std::string* text = find_text(node_, "wavelengths")) {
      wavelengths = parse_numbers(node_, *text);
    } else {
      const double lo = find_number(node_, "wavelength_min").value_or(360);
      const double hi = find_number(node_, "wavelength_max").value_or(830);
      for (size_t i = 0; i < numbers.size(); ++i)
        wavelengths.push_back(lo +
                              (hi - lo) * static_cast<double>(i) /
                                  std::max<double>(1, static_cast<double>(numbers.size()) - 1));
    }
    if (wavelengths.size() != numbers.size() || numbers.empty())
      node_.fail("expected as many wavelengths as values");
    std::vector<SpectrumPoint> points;
    for (size_t i = 0; i < numbers.size(); ++i)
      add_point(node_, points, {wavelengths[i], numbers[i]});
    return points;
  }

  const MitsubaNode& node_;
  ColorUse use_;
  MitsubaImport& import_;
};

}  // namespace

bool is_color(const MitsubaNode& node) {
  return node.tag == "rgb" || node.tag == "srgb" || node.tag == "spectrum" ||
         node.tag == "blackbody" || node.tag == "float" || node.tag == "color";
}

Rgb read_mitsuba_color(const MitsubaNode& node, ColorUse use, MitsubaImport& import) {
  Rgb color = ColorReader(node, use, import).read();
  if (use == ColorUse::kIndex && !(std::min({color.r, color.g, color.b}) >= 0)) {
    import.warn(node, "a negative index is drawn as 0");
    for (int i = 0; i < 3; ++i) color[i] = std::max(color[i], 0.0f);
  }
  if (!(max_component(color) <= kMaxRadiance)) node.fail("expected values up to 1e12");
  return color;
}

Rgb find_color(const MitsubaNode& plugin, std::string_view name, Rgb fallback, ColorUse use,
               MitsubaImport& import) {
  const MitsubaNode* parameter = find_parameter(plugin, name);
  if (!parameter) return fallback;
  const MitsubaNode& node = import.document.resolve(*parameter);
  if (is_color(node)) return read_mitsuba_color(node, use, import);
  import.warn(*parameter, "a texture of \"" + parameter->name + "\" is left out");
  return fallback;
}

}  // namespace qray
