// Mitsuba scenes of a few lines, for the importer's tests.
#pragma once

#include "tests/core/import/scene_text.h"

namespace qray::test {

inline const std::string kMitsubaSensor =
    "<sensor type=\"perspective\"><float name=\"fov\" value=\"90\"/></sensor>\n";
inline const std::string kMitsubaRectangle = "<shape type=\"rectangle\"/>\n";

// Three lines before `body`'s first: the scene's, a sensor's and a shape's.
inline std::string mitsuba_scene(const std::string& body, const std::string& version = "0.6.0") {
  return "<scene version=\"" + version + "\">\n" + kMitsubaSensor + kMitsubaRectangle + body +
         "\n</scene>\n";
}

// A shape with this BSDF alone is the scene.
inline std::string mitsuba_bsdf(const std::string& bsdf, const std::string& version = "0.6.0") {
  return "<scene version=\"" + version + "\">\n" + kMitsubaSensor + "<shape type=\"rectangle\">" +
         bsdf + "</shape>\n</scene>\n";
}

}  // namespace qray::test
