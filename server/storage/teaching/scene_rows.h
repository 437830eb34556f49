#pragma once

#include <vector>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "server/storage/audit/actor.h"
#include "server/storage/blobs/blobs.h"
#include "server/storage/engine/transactions.h"
#include "server/training/types.h"

namespace enamel::server {

// Scenes.
class SceneRows {
 public:
  SceneRows(Transactions& rows, Blobs& blobs) : rows_(rows), blobs_(blobs) {}

  Status PutScene(const SceneRow& row, const Actor& by);
  Result<std::vector<SceneRow>> Scenes();
  // The picture of a scene before it is cut, for all scenes with this volume.
  Status PutSceneSurface(const Sha256& volume, const Sha256& surface);

 private:
  Transactions& rows_;
  Blobs& blobs_;
};

}  // namespace enamel::server
