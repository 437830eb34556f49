import type { Role } from "../api/types";
import { unreachable } from "../base/assert";

// The addresses of the page. The server answers all of them with index.html.
const kLists = ["exercises", "attempts", "assignments", "cohorts", "people", "stations", "profiles", "live", "jobs", "audit", "health"] as const;
// Where a part of the address after the list names one thing of it.
const kThings = { exercises: "exercise", attempts: "attempt", assignments: "assignment", cohorts: "cohort", people: "person", profiles: "profile", live: "watch" } as const;
const kSingles = ["roster", "account", "grading", "editor"] as const;

type ListName = (typeof kLists)[number] | (typeof kSingles)[number];
type ThingName = (typeof kThings)[keyof typeof kThings];

export type Route =
  | { readonly name: "home" }
  | { readonly name: "unknown" }
  // `query`: what a list is narrowed to.
  | { [Name in ListName]: { readonly name: Name; readonly query: URLSearchParams } }[ListName]
  | { [Name in ThingName]: { readonly name: Name; readonly id: string } }[ThingName];

export function parseRoute(url: URL): Route {
  const [first, second, ...rest] = url.pathname.split("/").filter((part) => part !== "");
  if (first === undefined) return { name: "home" };
  if (rest.length > 0) return { name: "unknown" };
  const name = [...kLists, ...kSingles].find((item) => item === first);
  if (name === undefined) return { name: "unknown" };
  if (second === undefined) return { name, query: url.searchParams };
  const thing = name in kThings ? kThings[name as keyof typeof kThings] : undefined;
  return thing === undefined ? { name: "unknown" } : { name: thing, id: decoded(second) };
}

const kForAdmins: readonly Route["name"][] = ["people", "person", "roster", "jobs", "audit", "health"];

export function isForAdmins(route: Route): boolean {
  return kForAdmins.includes(route.name);
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
    case "student": return "/assignments";
    case "instructor": return "/attempts";
    case "admin": return "/people";
    default: return unreachable(role);
  }
}

export interface NavItem {
  readonly path: string;
  readonly title: string;
}

const kAttempts = { path: "/attempts", title: "Attempts" };
const kAssignments = { path: "/assignments", title: "Assignments" };
const kExercises = { path: "/exercises", title: "Exercises" };
const kCohorts = { path: "/cohorts", title: "Cohorts" };
const kLive = { path: "/live", title: "Live" };
const kStations = { path: "/stations", title: "Stations" };
const kDevices = { path: "/profiles", title: "Devices" };

export function navigation(role: Role): readonly NavItem[] {
  switch (role) {
    case "student": return [{ path: "/assignments", title: "My work" }, kExercises, { path: "/attempts", title: "My attempts" }];
    case "instructor": return [kAttempts, kAssignments, kExercises, kCohorts, kLive, kStations, kDevices];
    case "admin": return [
      { path: "/people", title: "People" }, kCohorts, kAttempts, kAssignments, kExercises, kLive, kStations, kDevices,
      { path: "/health", title: "Health" }, { path: "/jobs", title: "Jobs" }, { path: "/audit", title: "Audit" },
    ];
    default: return unreachable(role);
  }
}
