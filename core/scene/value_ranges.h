// The largest values that validate() lets through. Importers clamp to them, or refuse what is
// beyond.
#pragma once

namespace qray {

inline constexpr float kMaxCoordinate = 1e6f;  // metres: a float still resolves 6 cm there
inline constexpr float kMaxRadiance = 1e12f;   // the sun's disk: about 2e7; squares stay below 1e38
inline constexpr float kMaxAbsorption = 1e6f;  // 1/m
inline constexpr float kMaxSpecular = 1000;    // principled: what brings the least F0 to 1
inline constexpr float kMaxSlope = 1000;       // of normal and bump maps
inline constexpr float kMaxFilmNm = 1e5f;      // nanometres
inline constexpr float kMaxTurn = 6.2832f;     // radians: 360 degrees
inline constexpr float kMaxIndex = 20;         // of eta and k; real metals stay below 12

}  // namespace qray
