// The school to try the page by hand, until Ctrl-C; what is changed is forgotten.
//   node serve.mjs [DIST]      DIST: the built page, else web/dist
import { fileURLToPath } from "node:url";
import { kSchool, openSchool } from "./open.mjs";

const dist = process.argv[2] ?? fileURLToPath(new URL("../../../web/dist", import.meta.url));
const opened = await openSchool({ folder: kSchool, dist });
console.log(`page on ${opened.url}`);
for (const { login, password, name } of Object.values(opened.school.people))
  console.log(`  ${login.padEnd(12)} ${password.padEnd(32)} ${name}`);
process.once("SIGINT", async () => {
  await opened.close();
  process.exit(0);
});
