import { render } from "preact";
import { check } from "../base/assert";
import { App, askAhead, restoreSession } from "./app";
import { applyLanguage } from "./language";
import { followLinks } from "./location";

const root = document.getElementById("app");
check(root !== null, "index.html has an element with id app");
followLinks();
// Nothing can be said before its words are there.
void applyLanguage("", askAhead()).then((spoken) => {
  if (!spoken) {
    root.textContent = "This page could not be loaded. Diese Seite ließ sich nicht laden. 页面无法加载。";
    return;
  }
  render(<App />, root);
  void restoreSession();
});
