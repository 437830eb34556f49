#pragma once

#include <functional>

#include "common/base/bytes.h"
#include "common/base/sha256.h"
#include "common/core/params.h"
#include "common/scene/types.h"

// The documents of an attempt, for code that prepares one or checks a recording. Thread safety:
// functions, any thread. Real-time: not safe.
namespace enamel::scene {

struct AttemptDocuments {
  Exercise exercise;
  DeviceProfile profile;
  Scene scene;  // the exercise's
};

// The content of this hash: from a store, a cache, a server.
using FetchContent = std::function<Result<Bytes>(const Sha256&)>;

// Errors: `fetch`'s, and the documents' own.
Result<AttemptDocuments> ReadDocuments(const Sha256& exercise, const Sha256& profile,
                                       const FetchContent& fetch);

// Whether a recording that names this scene and volume, and was made with these parameters, was
// made of the documents. Errors: kConflict (field "scene", "volume" or "params"); CompilePlan's for
// documents that no longer give a plan.
Status CheckMadeOf(const AttemptDocuments& documents, const Sha256& scene, const Sha256& volume,
                   const core::CoreParams& params);

}  // namespace enamel::scene
