// Numbers as people type them, by one rule in every form. One number may have a comma or a point as its decimal mark. A list is parted
// by ; or by blanks or by a comma with a blank behind it; a comma between digits could be both, and is refused with both readings,
// unless ; parts the list.

const NUMBER = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i;

/** The number of a text, null for an empty one; an Error says what is wrong. */
export function oneNumber(text, name) {
  const typed = text.trim().replace("−", "-");
  if (!typed) return null;
  if ((typed.match(/[.,]/g) ?? []).length > 1) throw new Error(`${name} = ${typed} has two decimal marks; write it as 1234.5 or 1234,5`);
  const value = typed.replace(",", ".");
  if (!NUMBER.test(value)) throw new Error(`${name} = ${typed} must be a number such as 1.5 or 1,5`);
  return Number(value);
}

/** The numbers of a list; an Error says what is wrong. */
export function numberList(text, name) {
  const typed = text.trim().replaceAll("−", "-");
  if (typed.includes(";")) return typed.split(";").map((text) => text.trim()).filter(Boolean).map((text) => oneNumber(text, name));
  return typed.split(/,\s+|\s+|,$/).filter(Boolean).map((text) => {
    if (text.includes(",")) {
      const parts = text.split(",");
      if (parts.length === 2) throw new Error(`${name}: ${text} can be one number or two; write ${parts.join(".")} or ${parts.join(",")}; for the one number, ${parts.join("; ")} for two`);
      throw new Error(`${name}: ${text} can be read in more than one way; part the values of a list by ; as in ${parts.join("; ")}`);
    }
    if (!NUMBER.test(text)) throw new Error(`${name}: ${text} must be a number; part the values of a list by ; as in 2; 4,5; 8`);
    return Number(text);
  });
}
