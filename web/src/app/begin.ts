import { Ahead, askFirst } from "../api/ahead";
import { sendByFetch } from "../api/request_init";
import { type Drawer, startWorker } from "../tooth/start_worker";

// The page's first script: small, whole, and there before the others, which import it (scripts/build.mjs). Begins what
// takes longest: asking the server, and the graphics driver.

const [, list, thing] = /^\/(attempts|exercises)\/([^/]+)$/.exec(window.location.pathname) ?? [];
export const answers = new Ahead();
askFirst(answers, sendByFetch, list === "attempts" ? thing : undefined);

let begun: Drawer | undefined;
if (thing !== undefined) {
  try {
    begun = startWorker();
    // Nobody listens yet who could tell; another attempt is made when a tooth is to be shown.
    begun.worker.onerror = () => {
      begun = undefined;
    };
  } catch {
    // Told where the tooth would be.
  }
}

// What draws teeth: the one that was begun, given out once; else a new one. Throws where the browser refuses workers.
export function toothWorker(): Drawer {
  const drawer = begun ?? startWorker();
  begun = undefined;
  return drawer;
}
