// What the seeds of a row have in common, their bias, and what each has of its own: which is drawn and listed of it.

import { isOver, type BiasAndVariance, type ComparisonReport, type ComparisonRow } from "../api/types";
import { alwaysLayers, isMeasured } from "../api/vocabulary";
import { errorWithInterval } from "../ui/error_interval";
import { numberText } from "../ui/format";
import { rowName } from "./series";

/** An error that a row does not go below, however many passes it has. */
export interface Floor {
  row: number;
  name: string;
  error: number;
}

/** The mean of squares that a metric is, or that it is the root of: bias and variance are told apart of those. */
export const meanSquare = (metric: string): string => metric.replace(/\brmse$/, "mse");

/** Of the rows whose bias is told apart from 0, and does not shrink with the passes: the least that it may be. */
export function floorsOf(rows: ComparisonRow[], metric: string): Floor[] {
  const square = meanSquare(metric);
  return rows.flatMap((row, index) => {
    const bias = row.bias?.[square];
    if (!bias?.floor || !(bias.squared_bias > 0) || !(bias.low > 0)) return [];
    return [{ row: index, name: rowName(row), error: square === metric ? bias.low : Math.sqrt(bias.low) }];
  });
}

/** Whether bias is still to come: it is measured when a comparison is over, and a job that renders comes first. */
export const awaitsBias = (report: ComparisonReport): boolean =>
  isOver(report.state) && report.reference?.form === "two_films" && report.table.some((row) => row.seeds > 1 && row.succeeded === row.seeds && !row.bias);

export interface BiasLine {
  row: number;
  name: string;
  seeds: number;
  bias: BiasAndVariance;
}

export const biasLines = (rows: ComparisonRow[], metric: string): BiasLine[] =>
  rows.flatMap((row, index) => {
    const bias = row.bias?.[meanSquare(metric)];
    return bias ? [{ row: index, name: rowName(row), seeds: row.seeds, bias }] : [];
  });

export const biasText = (bias: BiasAndVariance): string => errorWithInterval(bias.squared_bias, [bias.low, bias.high]);

/** Two seeds tell no interval of it. */
export const varianceText = (bias: BiasAndVariance): string =>
  bias.variance_low === null || bias.variance_high === null ? numberText(bias.variance) : errorWithInterval(bias.variance, [bias.variance_low, bias.variance_high]);

/** Of which there are maps: the parts of the light that every film of the comparison has. */
export const mapLayers = (report: ComparisonReport): string[] => [...new Set([...alwaysLayers(), ...(report.request.layers ?? [])])].filter(isMeasured);

/** The layer that a metric measures: "indirect" of "indirect:relative_mse". */
export const layerOf = (metric: string): string => (metric.includes(":") ? metric.split(":", 1)[0]! : "beauty");
