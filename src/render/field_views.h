/// \file
/// Views of a scene's fields, which the walks read.
#pragma once

#include <glm/vec3.hpp>

#include "tyndall/medium/field_list.h"
#include "tyndall/scene/fields.h"

namespace tyndall {

// view(): \param origin of the view's field space, in the scene's: 0 except for solids.
// finest_feature(): edge of the finest feature that ray marching resolves, in units of the view.
#define TYN_VIEW(Field, name)                                      \
  Field view(const scene::Field& field, const glm::dvec3& origin); \
  double finest_feature(const scene::Field& field);
TYN_FOR_EACH_FIELD(TYN_VIEW)
#undef TYN_VIEW

}  // namespace tyndall
