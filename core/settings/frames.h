// The frames of a job: each has a camera, and a time where the scene moves. A job without "frames"
// has one. Pure.
#pragma once

#include <string>
#include <vector>

#include "core/scene/scene.h"
#include "core/settings/job_request.h"
#include "core/settings/render_settings.h"

namespace qray {

constexpr int kMaxFrames = 1000;  // of a job

// Whether the request asks for frames, be it one.
bool asks_for_frames(const JobRequest& request);
// The rules that hold between the fields of "frames". Errors name one of them.
Status check_frames(const JobRequest& request);
// How many: none where the scene is to say (the camera "*", an animation's end).
std::optional<int> frame_count(const JobRequest& request);

struct JobFrame {
  std::string name;  // of the camera; empty: it is none of the scene's own
  Camera camera;
  std::optional<double> seconds;  // of what moves; none: the scene is at rest
};
// In the order of their numbers. Errors name the field: a camera that the scene does not have, a
// turntable whose axis leads through the camera, a scene that does not move.
Result<std::vector<JobFrame>> frames_of(const JobRequest& request, const Scene& scene);
// Puts what the scene says: the names of its cameras for "*", when its animation ends.
void complete_frames(JobRequest& request, const Scene& scene);
// Of a frame: the name of its camera as far as the request tells; empty: it does not.
std::string camera_name(const JobRequest& request, int frame);

// "frame-0003.png": of the picture of a frame, where each is a file.
std::string frame_file_name(int frame, const std::string& format);

// In which views are rendered: each next one far from those before, so that a table soon knows
// what all of them see. The numbers with their bits reversed, in rising order of these.
std::vector<int> spread_order(int count);

// Of one frame: its camera, and its seed, which is a function of the job's unless all share it.
RenderSettings frame_settings(const JobRequest& request, RenderSettings settings,
                              const std::vector<JobFrame>& frames, int frame);

}  // namespace qray
