// Blind marking, which few open and seldom: a part of the page of its own.
export { MarkingPage } from "../features/marking/marking_page";
