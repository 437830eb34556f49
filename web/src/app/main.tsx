import { render } from "preact";
import { check } from "../base/assert";
import { formatDateTime } from "../base/format";
import { App, beginParts, restoreSession } from "./app";
import { applyLanguage } from "./language";
import { followLinks } from "./location";

const root = document.getElementById("app");
check(root !== null, "index.html has an element with id app");
followLinks();
const kSoonMs = 100; // nobody misses a page that says that it waits
// Nothing can be said before its words are there.
void applyLanguage("", beginParts()).then(async (spoken) => {
  if (!spoken) {
    root.textContent = "This page could not be loaded. Diese Seite ließ sich nicht laden. 页面无法加载。";
    return;
  }
  const answered = restoreSession();
  // While the server is asked: the first date takes the browser as long as a screen.
  formatDateTime(Date.now());
  await Promise.race([answered, new Promise((resolve) => setTimeout(resolve, kSoonMs))]);
  render(<App />, root);
});
