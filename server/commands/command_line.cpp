#include "server/commands/command_line.h"

#include <cstdlib>

#include "common/program/example.h"
#include "server/training/types.h"

namespace enamel::server::app {

std::vector<std::string> RoleNames() {
  std::vector<std::string> out;
  for (Role role : {Role::kStudent, Role::kInstructor, Role::kAdmin})
    out.emplace_back(RoleName(role));
  return out;
}

// The environment is read here and not by the parser, which would let it overrule another command's
// option that has the same place.
CLI::Option* AddData(CLI::App* cmd, std::filesystem::path& data) {
  auto* option = cmd->add_option("--data", data, "Data folder of the server (or ENAMEL_DATA)");
  const char* given = std::getenv("ENAMEL_DATA");
  if (given != nullptr) data = given;
  return option->required(given == nullptr);
}

void AddExample(CLI::App* cmd, const std::string& arguments) {
  program::AddExamples(*cmd,
                       {arguments + (arguments.empty() ? "" : " ") + "--data /var/lib/enamel"});
}

void AddIdentity(CLI::App* cmd, std::filesystem::path& identity) {
  cmd->add_option("--identity", identity,
                  "Folder with station.crt, station.key and ticket.key of another server of the "
                  "school: taken over where there are none, and refused where there are others");
}

void AddPlaces(CLI::App* cmd, Places& places) {
  auto* database = cmd->add_option("--database", places.database,
                                   "Keep the rows in this PostgreSQL 15 database instead of "
                                   "enamel.db: postgresql://USER@HOST/NAME");
  cmd->add_option("--schema", places.schema, "Name of the tables' place in that database")
      ->needs(database)
      ->capture_default_str();
  auto* endpoint = cmd->add_option("--s3-endpoint", places.blobs.endpoint,
                                   "Keep the blobs in this S3 store instead of the folder: "
                                   "https://HOST[:PORT]");
  auto* bucket = cmd->add_option("--s3-bucket", places.blobs.bucket, "Its bucket")->needs(endpoint);
  endpoint->needs(bucket);
  cmd->add_option("--s3-region", places.blobs.region,
                  "Region that requests are signed for; without: us-east-1")
      ->needs(endpoint);
  cmd->add_option("--s3-prefix", places.blobs.prefix, "Of every key in the bucket: school/")
      ->needs(endpoint);
  cmd->add_option("--s3-ca-file", places.blobs.ca_file,
                  "PEM file of the authority that signed the store's certificate")
      ->needs(endpoint);
  cmd->add_option("--s3-credentials", places.blobs.credentials_file,
                  "File of its access key (schemas/database.md); without: AWS_ACCESS_KEY_ID and "
                  "AWS_SECRET_ACCESS_KEY, for every command")
      ->needs(endpoint);
  auto* keys = cmd->add_option("--key-bucket", places.keys.bucket.bucket,
                               "Keep the keys of people's recordings in this bucket of the store, "
                               "for several servers: one that keeps no versions and locks nothing")
                   ->needs(endpoint);
  auto* master = cmd->add_option("--master-key", places.keys.master_key_file,
                                 "File of the key that they are wrapped with, the same on all "
                                 "servers; made by the first")
                     ->needs(keys);
  keys->needs(master);
  cmd->add_option("--key-prefix", places.keys.bucket.prefix, "Of every key in that bucket")
      ->needs(keys);
  cmd->add_option("--key-credentials", places.keys.bucket.credentials_file,
                  "File of that bucket's access key; without: that of the blobs")
      ->needs(keys);
}

}  // namespace enamel::server::app
