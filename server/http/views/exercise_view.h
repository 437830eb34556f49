#pragma once

#include <boost/json.hpp>
#include <memory>

#include "common/scene/types.h"
#include "server/storage/recordings/stored_blobs.h"
#include "server/training/types.h"

// Exercises as the API shows them (schemas/api/openapi.yaml). Thread safety: any thread.
namespace enamel::server::http {

using ExerciseDocument = std::shared_ptr<const scene::Exercise>;

// The exercise's document, read and parsed once and then kept: it never changes under its hash.
// Whether the caller may see the exercise was decided by its row. Errors: those of the blobs;
// kVersion, kInvalidInput of a document that this server cannot read.
Result<ExerciseDocument> DocumentOf(StoredBlobs& blobs, const ExerciseRow& row);

// As a row of a list, with what `viewer` may do with it.
boost::json::object SummaryJson(const Person& viewer, const ExerciseRow& row,
                                const scene::Exercise& exercise, bool has_reference,
                                int own_attempts);
// Adds to a summary what the page of one exercise shows, but for the rubric.
void AddWhole(StoredBlobs& blobs, const ExerciseRow& row, const scene::Exercise& exercise,
              boost::json::object& out);
boost::json::object RubricJson(const scene::Rubric& rubric);

}  // namespace enamel::server::http
