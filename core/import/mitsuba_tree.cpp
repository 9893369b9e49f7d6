#include "core/import/mitsuba_tree.h"

#include <algorithm>
#include <cctype>
#include <pugixml.hpp>

#include "core/base/file.h"
#include "core/import/scene_folder.h"

namespace qray {
namespace {

constexpr uint64_t kMaxXmlBytes = uint64_t{64} << 20;  // of all files together
constexpr size_t kMaxNodes = 1'000'000;
constexpr size_t kMaxElementDepth = 64;  // of elements, over all includes
constexpr size_t kMaxIncludeDepth = 16;  // of files
constexpr size_t kMaxFiles = 256;
constexpr size_t kMaxAttributeBytes = 16 << 20;  // what $parameters may grow to, in all

// Every element of Mitsuba 0.4 to 3.
constexpr std::string_view kTags[] = {
    "alias",   "animation", "blackbody", "boolean", "bsdf",    "color",      "default",
    "emitter", "film",      "float",     "include", "integer", "integrator", "look_at",
    "lookAt",  "lookat",    "luminaire", "matrix",  "medium",  "path",       "phase",
    "point",   "ref",       "rfilter",   "rgb",     "rotate",  "sampler",    "scale",
    "sensor",  "shape",     "spectrum",  "srgb",    "string",  "subsurface", "tensor",
    "texture", "transform", "translate", "vector",  "volume",
};

// Where the newlines of a text are.
class Lines {
 public:
  explicit Lines(const Bytes& text) {
    for (size_t i = 0; i < text.size(); ++i)
      if (text[i] == '\n') ends_.push_back(i);
  }
  size_t line(ptrdiff_t offset) const {
    const auto at = static_cast<size_t>(std::max<ptrdiff_t>(offset, 0));
    return static_cast<size_t>(std::lower_bound(ends_.begin(), ends_.end(), at) - ends_.begin()) +
           1;
  }

 private:
  std::vector<size_t> ends_;
};

class TreeReader {
 public:
  MitsubaDocument read(const std::filesystem::path& path) {
    std::error_code ec;
    const std::filesystem::path canonical = std::filesystem::canonical(path, ec);
    if (ec) fail_import(ErrorCode::kNotFound, "no such file", path.filename());
    document_.folder = canonical.parent_path();
    document_.folders.push_back(document_.folder);
    MitsubaNode scene;
    read_file_into(canonical, path.filename(), scene, 0);
    document_.root = std::move(scene);
    add_ids(document_.root);
    return std::move(document_);
  }

 private:
  // The children of the file's <scene>, and for the first file its attributes too.
  void read_file_into(const std::filesystem::path& path, const std::string& shown,
                      MitsubaNode& scene, size_t depth) {
    if (++file_count_ > kMaxFiles)
      fail_import(ErrorCode::kTooLarge, "expected at most 256 files", shown);
    const Result<Bytes> read = read_file(path, kMaxXmlBytes - bytes_read_);
    if (!read.ok()) throw ImportFailure{{read.error().code, read.error().message, shown}};
    const Bytes& text = read.value();
    bytes_read_ += text.size();
    const Lines lines(text);
    pugi::xml_document xml;
    const pugi::xml_parse_result parsed = xml.load_buffer(text.data(), text.size());
    if (!parsed) {
      fail_import(ErrorCode::kInvalid, std::string("expected XML: ") + parsed.description(),
                  shown + ":" + std::to_string(lines.line(parsed.offset)));
    }
    const pugi::xml_node root = xml.document_element();
    const std::string where = shown + ":" + std::to_string(lines.line(root.offset_debug()));
    if (std::string_view(root.name()) != "scene")
      fail_import(ErrorCode::kInvalid, "expected <scene>, got <" + std::string(root.name()) + ">",
                  where);
    files_.push_back(path);
    if (depth == 0) {
      scene.tag = "scene";
      scene.where = where;
      document_.version = std::atoi(root.attribute("version").value());
    }
    for (const pugi::xml_node child : root.children())
      add_child(child, File{shown, lines, depth}, scene, depth + 1);
    files_.pop_back();
  }

  struct File {
    const std::string& shown;
    const Lines& lines;
    size_t include_depth;
  };

  void add_child(const pugi::xml_node& xml, const File& file, MitsubaNode& parent, size_t depth) {
    if (xml.type() != pugi::node_element) return;
    MitsubaNode node;
    node.tag = xml.name();
    node.where = file.shown + ":" + std::to_string(file.lines.line(xml.offset_debug()));
    if (++node_count_ > kMaxNodes)
      node.fail("expected at most 1000000 elements", ErrorCode::kTooLarge);
    if (depth > kMaxElementDepth) node.fail("expected at most 64 levels", ErrorCode::kTooLarge);
    for (const pugi::xml_attribute attribute : xml.attributes()) {
      const std::string key = attribute.name();
      std::string value = put_in_parameters(attribute.value(), node);
      if (key == "type")
        node.type = std::move(value);
      else if (key == "id")
        node.id = std::move(value);
      else if (key == "name")
        node.name = node.tag == "default" ? std::move(value) : to_snake_case(value);
      else
        node.attributes.emplace_back(to_snake_case(key), std::move(value));
    }
    if (node.tag == "default") return add_parameter(node);
    if (node.tag == "include") return include(node, file, parent);
    if (node.tag == "path") return add_folder(node);
    if (node.tag == "alias") {
      aliases_.push_back(std::move(node));
      return;
    }
    for (const pugi::xml_node child : xml.children()) add_child(child, file, node, depth + 1);
    skip_foreign(node);
    parent.children.push_back(std::move(node));
  }

  // Other programs' elements, but for those that stand alone for a value: what needs that value
  // then names the place.
  void skip_foreign(MitsubaNode& node) {
    const auto is_known = [](const MitsubaNode& child) {
      return std::find(std::begin(kTags), std::end(kTags), child.tag) != std::end(kTags);
    };
    const auto is_replaced = [&](const MitsubaNode& foreign) {
      if (foreign.name.empty() && node.tag != "transform") return true;
      return std::any_of(node.children.begin(), node.children.end(), [&](const MitsubaNode& other) {
        return is_known(other) && other.name == foreign.name;
      });
    };
    for (MitsubaNode& child : node.children) {
      if (is_known(child) || !is_replaced(child)) continue;
      document_.skipped.emplace_back(child.where, child.tag);
      child.tag.clear();
    }
    std::erase_if(node.children, [](const MitsubaNode& child) { return child.tag.empty(); });
  }

  // What was set first counts: the including file's over the included one's.
  void add_parameter(const MitsubaNode& node) {
    if (node.name.empty()) node.fail("expected a \"name\"");
    parameters_.emplace(node.name, node.need("value"));
  }

  // The longest name that fits. What no <default> names is left as it is: where it matters, a
  // number is expected and "$name" found.
  std::string put_in_parameters(std::string_view text, const MitsubaNode& node) {
    std::string out;
    for (size_t i = 0; i < text.size();) {
      if (text[i] != '$') {
        out += text[i++];
        continue;
      }
      size_t end = i + 1;
      while (end < text.size() && (std::isalnum(static_cast<unsigned char>(text[end])) != 0 ||
                                   text[end] == '_' || text[end] == '-'))
        ++end;
      auto found = parameters_.end();
      for (; end > i + 1; --end) {
        found = parameters_.find(text.substr(i + 1, end - i - 1));
        if (found != parameters_.end()) break;
      }
      if (found == parameters_.end()) {
        out += text[i++];
        continue;
      }
      out += found->second;
      i = end;
      attribute_bytes_ += found->second.size();
      if (attribute_bytes_ > kMaxAttributeBytes)
        node.fail("the parameters put in grow too large", ErrorCode::kTooLarge);
    }
    return out;
  }

  void include(const MitsubaNode& node, const File& file, MitsubaNode& parent) {
    const std::string& name = node.need("filename");
    if (file.include_depth + 1 >= kMaxIncludeDepth)
      node.fail("expected includes of at most 16 levels", ErrorCode::kTooLarge);
    const std::filesystem::path path = document_.find_file(node, name);
    if (std::find(files_.begin(), files_.end(), path) != files_.end())
      node.fail("\"" + name + "\" includes itself");
    MitsubaNode scene;
    read_file_into(path, path.lexically_relative(document_.folder), scene, file.include_depth + 1);
    std::move(scene.children.begin(), scene.children.end(), std::back_inserter(parent.children));
  }

  void add_folder(const MitsubaNode& node) {
    const std::optional<std::filesystem::path> path =
        follow_within(document_.folder, document_.folder, node.need("value"));
    if (!path || !std::filesystem::is_directory(*path))
      node.fail("expected a folder within the scene's", ErrorCode::kNotFound);
    document_.folders.push_back(*path);
  }

  void add_ids(const MitsubaNode& node) {
    collect_ids(node);
    for (const MitsubaNode& alias : aliases_) {
      const auto it = document_.ids.find(alias.id);
      if (it == document_.ids.end()) alias.fail("no element has the id \"" + alias.id + "\"");
      document_.ids.emplace(alias.need("as"), it->second);
    }
  }
  void collect_ids(const MitsubaNode& node) {
    if (!node.id.empty() && node.tag != "ref") {
      const auto [it, is_new] = document_.ids.emplace(node.id, &node);
      if (!is_new)
        node.fail("the id \"" + node.id + "\" is taken by the element at " + it->second->where);
    }
    for (const MitsubaNode& child : node.children) collect_ids(child);
  }

  MitsubaDocument document_;
  std::map<std::string, std::string, std::less<>> parameters_;
  std::vector<std::filesystem::path> files_;  // being read, outermost first
  std::vector<MitsubaNode> aliases_;
  size_t file_count_ = 0, node_count_ = 0, attribute_bytes_ = 0;
  uint64_t bytes_read_ = 0;
};

}  // namespace

const std::string* MitsubaNode::attribute(std::string_view key) const {
  for (const auto& [name, value] : attributes)
    if (name == key) return &value;
  return nullptr;
}

const std::string& MitsubaNode::need(std::string_view key) const {
  const std::string* value = attribute(key);
  if (!value) fail("expected an attribute \"" + std::string(key) + "\" of <" + tag + ">");
  return *value;
}

void MitsubaNode::fail(const std::string& message, ErrorCode code) const {
  fail_import(code, message, where);
}

const MitsubaNode& MitsubaDocument::resolve(const MitsubaNode& node) const {
  if (node.tag != "ref") return node;
  const auto it = ids.find(node.id);
  if (it == ids.end()) node.fail("no element has the id \"" + node.id + "\"");
  return *it->second;
}

std::filesystem::path MitsubaDocument::find_file(const MitsubaNode& node,
                                                 const std::string& name) const {
  std::string slashed = name;
  std::replace(slashed.begin(), slashed.end(), '\\', '/');
  for (const std::filesystem::path& from : folders) {
    const Result<std::filesystem::path> path = find_within(folder, from, slashed);
    if (path.ok()) return path.value();
  }
  node.fail("no such file in the scene's folder: \"" + name + "\"", ErrorCode::kNotFound);
}

MitsubaDocument read_mitsuba_tree(const std::filesystem::path& path) {
  return TreeReader().read(path);
}

std::string to_snake_case(std::string_view name) {
  std::string out;
  for (size_t i = 0; i < name.size(); ++i) {
    const auto c = static_cast<unsigned char>(name[i]);
    if (std::isupper(c) != 0 && i > 0 && std::isupper(static_cast<unsigned char>(name[i - 1])) == 0)
      out += '_';
    out += static_cast<char>(std::tolower(c));
  }
  return out;
}

}  // namespace qray
