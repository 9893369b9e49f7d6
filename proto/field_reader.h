// Reading of requests by a table of fields (core/settings/job_fields.h). Any thread.
#pragma once

#include "proto/request_reader.h"

namespace qray::proto {

// The largest value that both the table and the server's limits allow.
double most_of(const Field& field, const RequestLimits& limits);

// Gives `out` each field of the table that the caller may give, from the object `tree`; other
// members are errors, and so are settings of the guide that the request's method does not have.
void read_fields(const Json& tree, const FieldTable& fields, unsigned caller,
                 const RequestLimits& limits, JobRequest& out, std::vector<FieldError>& errors);
// One of them.
void read_field(ObjectReader& in, const Field& field, unsigned caller, const RequestLimits& limits,
                JobRequest& out);
// The members of the group that `in` has under its name; nothing where it has none.
void read_group(ObjectReader& in, std::string_view group, const FieldTable& fields, unsigned caller,
                const RequestLimits& limits, JobRequest& out, std::vector<FieldError>& errors);

// One of a list of cameras: a name, or an object of the members of "camera".
CameraChoice read_camera(const Json& tree, const std::string& pointer, const FieldTable& fields,
                         unsigned caller, const RequestLimits& limits,
                         std::vector<FieldError>& errors);

}  // namespace qray::proto
