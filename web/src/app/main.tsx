import { render } from "preact";
import { check } from "../base/assert";
import { App, restoreSession } from "./app";
import { followLinks } from "./location";

const root = document.getElementById("app");
check(root !== null, "index.html has an element with id app");
followLinks();
render(<App />, root);
void restoreSession();
