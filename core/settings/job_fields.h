// The one list of what a job or a live session may be told: names, types, units, ranges, defaults,
// help, and who may give each. The readers and writers of JSON, the command's options, variants of
// charts, the page's form and check_settings() are made of it; proto/openapi.yaml is compared with
// it by a test. Immutable; any thread.
#pragma once

#include "core/settings/field.h"

namespace qray {

const FieldTable& job_fields();
// Of POST /v1/live: those of job_fields() that a session has, with its own ranges and defaults, and
// what only a session has.
const FieldTable& live_fields();

}  // namespace qray
