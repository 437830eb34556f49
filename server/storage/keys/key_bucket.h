#pragma once

#include "common/base/result.h"
#include "common/s3/s3_client.h"

namespace enamel::server {

// A bucket that is to have a key ring (keyring.h) must forget what is deleted in it: an erasure
// destroys a person's key, and a key that can be brought back was not destroyed. One that keeps
// versions, or kept them once (what was kept stays), or that may be locked against deleting, is
// refused; so is one that does not say.
//
// What S3 does not tell is not found: copies to another bucket, backups of the store, Swift's older
// X-Versions-Location.
// Errors: kForbidden (it keeps what is deleted), and those of S3Client. Thread safety: any thread.
Status MustForgetWhatIsDeleted(s3::S3Client& bucket);

}  // namespace enamel::server
