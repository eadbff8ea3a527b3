// Colours that tell series apart, for readers with any colour vision [Okabe and Ito 2008, Color Universal Design],
// with a dash and a mark each, so that no figure needs colour at all. Two sets: on dark and on light ground.

export interface SeriesLook {
  colour: string;
  dash: number[];
  symbol: "circle" | "square" | "triangle" | "diamond" | "cross" | "star";
}

const kOnLight = ["#0072b2", "#d55e00", "#007a5a", "#aa4499", "#8a6d00", "#332288", "#882255", "#444444"];
const kOnDark = ["#56b4e9", "#ff9e4a", "#2fd0a0", "#e78ac8", "#f0e442", "#a79bff", "#ff7f9f", "#d0d0d0"];
const kDashes = [[], [6, 3], [2, 2], [8, 3, 2, 3], [10, 4], [4, 2, 1, 2]];
const kSymbols: SeriesLook["symbol"][] = ["circle", "square", "triangle", "diamond", "cross", "star"];

/** The look of the series with this number; numbers past the last colour come round with another dash. */
export function seriesLook(index: number, dark: boolean): SeriesLook {
  const colours = dark ? kOnDark : kOnLight;
  return {
    colour: colours[index % colours.length]!,
    dash: kDashes[(index + Math.floor(index / colours.length)) % kDashes.length]!,
    symbol: kSymbols[(index + Math.floor(index / colours.length)) % kSymbols.length]!,
  };
}
