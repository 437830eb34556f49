import type { Role } from "../api/types";
import { unreachable } from "../base/assert";

// The addresses of the page. The server answers all of them with index.html.
export type Route =
  | { readonly name: "home" }
  | { readonly name: "exercises" }
  | { readonly name: "exercise"; readonly id: string }
  | { readonly name: "attempts"; readonly cohort: string | undefined }
  | { readonly name: "attempt"; readonly id: string }
  | { readonly name: "people" | "stations" | "profiles" | "jobs" | "audit" }
  | { readonly name: "unknown" };

const kAdminRoutes = ["people", "stations", "profiles", "jobs", "audit"] as const;

export function parseRoute(url: URL): Route {
  const [first, second, ...rest] = url.pathname.split("/").filter((part) => part !== "");
  if (first === undefined) return { name: "home" };
  if (rest.length > 0) return { name: "unknown" };
  if (first === "exercises") return second === undefined ? { name: "exercises" } : { name: "exercise", id: decoded(second) };
  if (first === "attempts") {
    if (second !== undefined) return { name: "attempt", id: decoded(second) };
    return { name: "attempts", cohort: url.searchParams.get("cohort") ?? undefined };
  }
  const admin = kAdminRoutes.find((name) => name === first);
  return admin !== undefined && second === undefined ? { name: admin } : { name: "unknown" };
}

function decoded(part: string): string {
  try {
    return decodeURIComponent(part);
  } catch {
    return part;
  }
}

export function homePath(role: Role): string {
  switch (role) {
    case "student": return "/exercises";
    case "instructor": return "/attempts";
    case "admin": return "/people";
    default: return unreachable(role);
  }
}

export interface NavItem {
  readonly path: string;
  readonly title: string;
}

export function navigation(role: Role): readonly NavItem[] {
  const exercises = { path: "/exercises", title: "Exercises" };
  const profiles = { path: "/profiles", title: "Devices" };
  const stations = { path: "/stations", title: "Stations" };
  switch (role) {
    case "student": return [exercises, { path: "/attempts", title: "My attempts" }];
    case "instructor": return [{ path: "/attempts", title: "Attempts" }, exercises, stations, profiles];
    case "admin": return [
      { path: "/people", title: "People" }, { path: "/attempts", title: "Attempts" }, exercises, stations, profiles,
      { path: "/jobs", title: "Jobs" }, { path: "/audit", title: "Audit" },
    ];
    default: return unreachable(role);
  }
}
