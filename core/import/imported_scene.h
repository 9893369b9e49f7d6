// What every reader of a scene's format gives: the scene as its file says it, and what errors and
// warnings need to name the place. Plain data.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/scene/scene.h"

namespace qray {

inline constexpr size_t kMaxWarnings = 1000;  // of one scene

// Not validated yet.
class ImportedScene {
 public:
  Scene scene;
  std::vector<std::string> warnings;  // things understood and left out, with their place
  // What was said of another place before is only counted.
  void warn(const std::string& place, const std::string& text) {
    if (const auto said = said_.find(text); said != said_.end()) {
      ++said->second.more;
    } else if (warnings.size() < kMaxWarnings) {
      said_.emplace(text, Said{warnings.size(), 0});
      warnings.push_back(place + ": " + text);
    }
  }
  // At the end, once: in how many more places each warning holds.
  void add_counts_to_warnings() {
    for (const auto& [text, said] : said_) {
      if (said.more == 0) continue;
      warnings[said.index] +=
          " (and in " + std::to_string(said.more) + " more place" + (said.more > 1 ? "s)" : ")");
    }
    said_.clear();
  }
  // Where scene.meshes[i] was read from, as a pointer into the document: a file may hold several.
  std::vector<std::string> mesh_pointers;
  std::vector<std::string> instance_pointers;  // of scene.instances[i]

 private:
  struct Said {
    size_t index, more;
  };
  std::map<std::string, Said> said_;
};

}  // namespace qray
