#include "server/storage/keys/key_bucket.h"

#include <string>

namespace enamel::server {

Status MustForgetWhatIsDeleted(s3::S3Client& bucket) {
  ENAMEL_ASSIGN_OR_RETURN(const auto versioning, bucket.GetBucketVersioning());
  if (versioning != s3::Versioning::kNever) {
    const bool on = versioning == s3::Versioning::kEnabled;
    return Status(Code::kForbidden,
                  "expected a bucket for keys that forgets what is deleted, found that versioning "
                  "is " +
                      std::string(on ? "on" : "suspended, so that earlier versions stay") + " at " +
                      bucket.Where() +
                      ": an erased person's key could be brought back; name a new bucket without "
                      "versioning");
  }
  ENAMEL_ASSIGN_OR_RETURN(const bool locked, bucket.GetObjectLockConfiguration());
  if (!locked) return Status::Ok();
  return Status(
      Code::kForbidden,
      "expected a bucket for keys that forgets what is deleted, found that objects may be "
      "locked at " +
          bucket.Where() +
          ": an erased person's key might not be deleted; name a new bucket without "
          "object lock");
}

}  // namespace enamel::server
