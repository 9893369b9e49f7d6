// The rows of the table of job fields that are about methods: which there are, and each one's own
// settings. What a new method adds to the table stands in guide_fields.cpp.
#pragma once

#include "core/settings/field.h"

namespace qray {

Field method_field();
FieldTable guide_fields();

}  // namespace qray
