#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/storage/people/people_rows.h"

namespace enamel::server::app {

struct SeedOptions {
  std::filesystem::path data;
  std::string scene;           // folder of an imported scene, offered besides the built-in molar
  int32_t voxel_um = 50;       // of the built-in molar
  std::filesystem::path json;  // facts as JSON; empty: none
};

// Creates people admin, instructor, student1, student2 with the public passwords
// enamel-demo-<login>; a cohort of the last three; the three device profiles; the built-in molar;
// its class I exercise for the cohort. Idempotent: existing data stays (also changed passwords).
// Only for servers on loopback. `begin` is called with the name of each part that takes seconds.
Status SeedDemo(const SeedOptions& options, const std::function<void(const std::string&)>& begin);

// Those of them that may sign in with their public password. Blocks: one argon2id each.
Result<std::vector<std::string>> LoginsWithDemoPassword(PeopleRows& people);

}  // namespace enamel::server::app
