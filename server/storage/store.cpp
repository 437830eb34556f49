#include "server/storage/store.h"

#include <utility>

#include "server/storage/store_engine.h"

namespace enamel::server {

Store::Store(std::unique_ptr<StoreEngine> on)
    : engine(std::move(on)),
      shared(engine->rows.shared()),
      people(engine->rows, *engine->keyring),
      roster(engine->rows),
      sessions(engine->rows, engine->look),
      sign_ins(engine->rows, engine->ticket_key),
      cohorts(engine->rows),
      stations(engine->rows),
      devices(engine->rows),
      settings(engine->rows),
      saved_texts(engine->rows),
      schools(engine->rows),
      profiles(engine->rows, *engine->blobs),
      scenes(engine->rows, *engine->blobs),
      exercises(engine->rows),
      rubrics(engine->rows, *engine->blobs),
      assignments(engine->rows),
      blobs(engine->gate, *engine->blobs, *engine->keyring, engine->keys),
      attempts(engine->rows),
      recordings(engine->rows, *engine->keyring, blobs),
      tickets(engine->rows, engine->gate, *engine->keyring, engine->keys),
      sign_offs(engine->rows),
      ingest(engine->rows, engine->gate, *engine->keyring, engine->keys, recordings,
             engine->counters),
      seals(engine->rows, engine->gate, *engine->blobs, blobs, recordings,
            engine->sealed ? &*engine->sealed : nullptr, engine->counters, engine->part_bytes),
      motions(engine->rows),
      results(engine->rows, *engine->blobs),
      judging(engine->rows, seals),
      remarks(engine->rows),
      appeals(engine->rows),
      references(engine->rows),
      jobs(engine->rows, engine->owner),
      batches(engine->rows),
      timelines(engine->rows, *engine->blobs, engine->owner),
      live(engine->rows, engine->owner),
      audit(engine->rows),
      erasures(engine->rows, engine->rewriter, *engine->keyring, *engine->blobs,
               engine->sealed ? &*engine->sealed : nullptr),
      retention(engine->rows, engine->rewriter, *engine->blobs, sign_ins),
      health({engine->folder, engine->space, engine->rows, engine->rewriter, engine->look,
              engine->gate, *engine->blobs, *engine->keyring, engine->counters}),
      look(engine->look),
      identity(engine->rows),
      markings(engine->rows) {}

Store::~Store() = default;

void Store::StopWaiting() { engine->rows.writer().StopWaiting(); }

}  // namespace enamel::server
