#pragma once

#include "common/base/result.h"
#include "server/s3/s3_client.h"

namespace enamel::server {

// A bucket for a key ring (keyring.h) must forget deleted objects: an erasure destroys a person's
// key, and a key that can be brought back was not destroyed. Refuses a bucket that keeps versions,
// once kept them (old versions stay), may be locked against deletion, or does not report this.
//
// It cannot find what S3 does not report: copies to another bucket, backups of the store, Swift's
// older X-Versions-Location. Errors: kForbidden (it keeps deleted objects), and those of S3Client.
// Thread safety: any thread.
Status MustForgetWhatIsDeleted(s3::S3Client& bucket);

}  // namespace enamel::server
