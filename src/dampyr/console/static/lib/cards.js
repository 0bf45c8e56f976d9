// Cards to choose from: those of the data folder, and published dampers.
import { h } from "./dom.js";

/** [words, [[name, title], ...]] of the cards of the data folder and of the published dampers. */
export function cardGroups(dampers) {
  const own = ({ name }) => name.startsWith("cards/");
  return [
    ["Cards", dampers.filter(own).map((damper) => [damper.name, damper.title])],
    ["Published dampers", dampers.filter((damper) => !own(damper)).map((damper) => [damper.name, damper.title.replace("published: ", "")])],
  ];
}

/** The options of a select, by groups; a group that is empty is left out. */
export const groupedOptions = (groups) => groups.filter(([, all]) => all.length).map(([label, all]) =>
  h("optgroup", { label }, all.map(([value, words]) => h("option", { value }, words))));
