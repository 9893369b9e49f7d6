// Mitsuba scene XML (0.4 to 0.6, 2 and 3) as a tree: parameters put in, includes expanded, every
// node with its file and line. Nothing is known of plugins here. Throws ImportFailure. Any thread.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/import/import_failure.h"

namespace qray {

// An XML element: <tag type="..." name="..." id="..." value="..."> with its children.
struct MitsubaNode {
  std::string tag;
  std::string type, id;  // empty: without
  std::string name;      // in snake_case: "toWorld" and "to_world" are one parameter
  std::string where;     // "scene.xml:12"
  std::vector<std::pair<std::string, std::string>> attributes;  // the others
  std::vector<MitsubaNode> children;

  const std::string* attribute(std::string_view key) const;  // null: without
  const std::string& need(std::string_view key) const;       // fails without
  [[noreturn]] void fail(const std::string& message, ErrorCode code = ErrorCode::kInvalid) const;
};

struct MitsubaDocument {
  MitsubaNode root;                            // <scene>
  int version = 0;                             // 0, 2, 3; 0 where none is given
  std::filesystem::path folder;                // of the scene file, canonical
  std::vector<std::filesystem::path> folders;  // where files are looked for, within `folder`
  std::map<std::string, const MitsubaNode*, std::less<>> ids;
  // Elements that Mitsuba does not have, which are left out: their place and tag.
  std::vector<std::pair<std::string, std::string>> skipped;

  MitsubaDocument() = default;
  MitsubaDocument(MitsubaDocument&&) = default;  // `ids` points to descendants, which stay
  MitsubaDocument& operator=(MitsubaDocument&&) = default;

  // The node itself, or what a <ref> names.
  const MitsubaNode& resolve(const MitsubaNode& node) const;
  // A file that a node names; it must be there and within `folder`. Fails in the node's place.
  std::filesystem::path find_file(const MitsubaNode& node, const std::string& name) const;
};

MitsubaDocument read_mitsuba_tree(const std::filesystem::path& path);

std::string to_snake_case(std::string_view name);  // intIOR: int_ior

}  // namespace qray
