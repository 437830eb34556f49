import { part } from "../../widgets/part";

export const Copying = part("copy_form", () => import("./copy_form"));
