import type { Client } from "../api/client";
import type { Person, Role } from "../api/types";
import { unreachable } from "../base/assert";
import { say } from "../base/words";

// The addresses of the page. The server answers all of them with index.html.
const kLists = [
  "exercises",
  "attempts",
  "assignments",
  "cohorts",
  "people",
  "stations",
  "profiles",
  "live",
  "markings",
  "jobs",
  "audit",
  "health",
] as const;
// Where a part of the address after the list names one thing of it.
const kThings = {
  exercises: "exercise",
  attempts: "attempt",
  assignments: "assignment",
  cohorts: "cohort",
  people: "person",
  profiles: "profile",
  live: "watch",
  markings: "marking",
} as const;
const kSingles = ["search", "roster", "account", "grading", "editor"] as const;

type ListName = (typeof kLists)[number] | (typeof kSingles)[number];
type ThingName = (typeof kThings)[keyof typeof kThings];

export type Route =
  | { readonly name: "home" }
  | { readonly name: "unknown" }
  // `query`: what a list is narrowed to.
  | { [Name in ListName]: { readonly name: Name; readonly query: URLSearchParams } }[ListName]
  | { [Name in ThingName]: { readonly name: Name; readonly id: string } }[ThingName];

// What a screen is given.
export interface ScreenProps {
  readonly client: Client;
  readonly route: Route;
  readonly person: Person;
  readonly onQuery: (query: Readonly<Record<string, string>>) => void;
  readonly onOpen: (path: string) => void;
}

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

const kForAdmins: readonly Route["name"][] = ["people", "person", "search", "roster", "jobs", "audit", "health"];

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
    case "student":
      return "/assignments";
    case "instructor":
      return "/attempts";
    case "admin":
      return "/people";
    default:
      return unreachable(role);
  }
}

export interface NavItem {
  readonly path: string;
  readonly title: string;
}

export function navigation(role: Role): readonly NavItem[] {
  const attempts = { path: "/attempts", title: say("nav.attempts") };
  const assignments = { path: "/assignments", title: say("nav.assignments") };
  const exercises = { path: "/exercises", title: say("nav.exercises") };
  const cohorts = { path: "/cohorts", title: say("nav.cohorts") };
  const live = { path: "/live", title: say("nav.live") };
  const stations = { path: "/stations", title: say("nav.stations") };
  const devices = { path: "/profiles", title: say("nav.devices") };
  switch (role) {
    case "student":
      return [
        { path: "/assignments", title: say("nav.my_work") },
        exercises,
        { path: "/attempts", title: say("nav.my_attempts") },
      ];
    case "instructor":
      return [attempts, assignments, exercises, cohorts, live, stations, devices];
    case "admin":
      return [
        { path: "/people", title: say("nav.people") },
        cohorts,
        attempts,
        assignments,
        exercises,
        live,
        stations,
        devices,
        { path: "/health", title: say("nav.health") },
        { path: "/jobs", title: say("nav.jobs") },
        { path: "/audit", title: say("nav.audit") },
      ];
    default:
      return unreachable(role);
  }
}
