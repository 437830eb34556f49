#pragma once

#include <boost/json/object.hpp>

#include "common/scene/json/read.h"
#include "common/scene/types.h"

// A rubric in a document: the member "rubric" of an exercise, or a document of its own
// (schemas/rubric.schema.json), which has "format" before it.
namespace enamel::scene {

boost::json::object RubricJson(const Rubric& rubric);
// Refuses maps that do not ascend and shares outside 0..1. Whether the metrics exist is for
// scoring::ValidateRubric. The caller reads further members and finishes.
Rubric ReadRubric(ObjectReader& in);

}  // namespace enamel::scene
