// What requests of jobs and of live sessions name must be there. Each adds what is wrong, by
// pointer. Any thread.
#pragma once

#include "proto/messages.h"
#include "server/jobs/job_runner.h"

namespace qray::server {

// Fills in the sizes that the request leaves to the scene.
void check_scene(const Stores& stores, const std::string& scene, std::optional<int>& width,
                 std::optional<int>& height, int64_t max_pixels,
                 std::vector<proto::FieldError>& errors);
// `table`: auto, none or an id. It must serve the method.
void check_table(const Stores& stores, const std::string& table, const std::string& method,
                 std::vector<proto::FieldError>& errors);
// `recover`: none, auto, a network that is included, or the id of weights.
void check_recover(const Stores& stores, const std::string& recover,
                   std::vector<proto::FieldError>& errors);

// None where there are no errors.
std::optional<proto::Problem> problem_of(std::vector<proto::FieldError> errors, std::string title);

}  // namespace qray::server
